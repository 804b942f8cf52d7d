"""Error recovery of the parser: after a syntax error it continues, and messages say what was expected."""
