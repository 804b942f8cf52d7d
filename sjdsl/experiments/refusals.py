"""The error of experiments and sweeps."""


class ExperimentError(Exception):
    """An experiment can't start or continue; the message says what to change."""
