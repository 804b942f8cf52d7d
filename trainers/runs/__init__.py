"""A whole training: its loop, and the files, checkpoints and curves in its folder."""
