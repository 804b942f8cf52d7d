"""What a report refuses."""


class ReportError(Exception):
    """A report cannot be made of what was given, or not where it was asked for; the message says what to change."""
