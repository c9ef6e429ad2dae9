"""WALTER Serial Command Protocol: Logo control and direct control (PROTOCOLS.md section 3)."""
