"""The errors of a run."""


class RunError(Exception):
    """A run can't start, or can't continue."""


class DiskError(RunError):
    """A file of a run couldn't be written; what was saved before is whole."""
