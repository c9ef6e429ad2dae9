"""Ways to carry bytes: serial port, TCP, pty, in-memory."""
