"""Diagnostics: positions in a text, error codes and messages, and how they are printed."""
