"""Virtual robots in a virtual world, at the far end of a wire."""
