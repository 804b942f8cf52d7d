"""Mistaken games, what is said of each, and what the message suggests: applied, it is accepted."""
