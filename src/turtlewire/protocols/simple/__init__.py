"""Enkelt protokoll: seven characters, answered K or F (docs/protocols/simple.md)."""
