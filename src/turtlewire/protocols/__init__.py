"""The three wire protocols, sans-IO: messages to bytes and back, both ends; no clock, no I/O."""
