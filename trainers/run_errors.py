"""Why a run cannot start, or cannot go on."""


class RunError(Exception):
    """A run cannot start, or cannot go on."""


class TooLargeError(RunError):
    """A run needs more memory than there is."""


class DiskError(RunError):
    """A file of a run could not be written; what was saved before is whole."""
