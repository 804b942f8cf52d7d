"""Policies by name and in files, and how well they do."""
