"""The reference interpreter: the meaning of a game in plain Python, slow and obvious, written from the manual alone."""
