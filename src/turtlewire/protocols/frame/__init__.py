"""Serial Protocol 0.1: frames of messages under a CRC, with dialects as data (docs/protocols/frame.md)."""
