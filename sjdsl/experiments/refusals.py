"""What an experiment refuses."""


class ExperimentError(Exception):
    """An experiment cannot be made, or cannot go on; the message says what to change."""
