"""Traces: what happens in a game, step by step and rule by rule, without JAX."""

from sjdsl.trace.effects import Effect, effects_of
from sjdsl.trace.episode import Moment, Turn, play, turn_of
from sjdsl.trace.rules import Rules

__all__ = ["Effect", "Moment", "Rules", "Turn", "effects_of", "play", "turn_of"]
