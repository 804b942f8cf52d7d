"""The release and the project's address, in their own file so that nothing else is imported."""

__version__ = "0.1.0"
