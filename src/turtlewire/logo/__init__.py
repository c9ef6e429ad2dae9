"""Logo: reader, syntax, evaluator; knows robots only as a Turtle."""
