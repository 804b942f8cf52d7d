"""The errors of models."""


class ModelError(Exception):
    """A model can't be asked; the message says what to change."""


class Unanswered(ModelError):
    """A call got no answer, though the server may have been at work on one, and may bill it."""


class LimitReached(ModelError):
    """The next call might pass a limit that the user has set; all replies so far are kept."""

    exit_status = 3  # of a command
