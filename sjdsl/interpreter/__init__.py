"""The reference interpreter: the semantics of a game in plain Python, slow and simple.

It is written from the manual alone.
"""
