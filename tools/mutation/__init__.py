"""Mutation of the firmware's core: small mistakes, made one at a time, that the fixed inputs have to notice."""
