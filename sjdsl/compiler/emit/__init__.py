"""Writes a lowered program as the text of a Python module."""
