"""Pictures, and boards in letters."""
