"""WALTER Serial Command Protocol: Logo control and direct control (docs/protocols/walter.md)."""
