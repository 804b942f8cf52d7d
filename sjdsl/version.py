"""The release, alone in its file so that whoever prints it imports nothing else."""

__version__ = "0.1.0"
