"""A prompt for Logo on any terminal: a line editor that knows the language, and errors marked at their place."""
