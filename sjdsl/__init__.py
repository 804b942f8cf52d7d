"""sjdsl: a compiler for sequential social dilemmas."""

__version__ = "0.1.0"
