"""turtlewire: drive, program and trust any small serial robot."""
