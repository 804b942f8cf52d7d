"""What loading results refuses, and what it warns of."""


class ResultsError(Exception):
    """Results cannot be loaded, or a report cannot be written to its place; the message says what to change."""


class ResultsWarning(UserWarning):
    """Something is left out of the results, or shown with a reservation; the message says what to do about it."""
