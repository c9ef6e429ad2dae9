"""The primitives of Logo, one file per chapter of the manual."""
