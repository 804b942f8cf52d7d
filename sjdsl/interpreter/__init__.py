"""The reference interpreter: the semantics of a game in plain Python, slow and simple, written from
the manual alone."""
