"""What is generated, one module a protocol: each has ``files()``, path -> text."""
