"""Error recovery of the parser: after a mistake it goes on, and the messages say what was expected."""
