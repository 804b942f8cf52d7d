"""The studio: a game's text beside its board, in a browser on this machine."""
