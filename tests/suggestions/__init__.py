"""Mistaken games, what is said of each, and a repair that is accepted."""
