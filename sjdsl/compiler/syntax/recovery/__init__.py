"""Error recovery: the parser continues after an error, and messages say what was expected."""
