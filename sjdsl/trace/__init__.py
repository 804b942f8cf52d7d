"""Traces: what happens in a game step by step and rule by rule, on the reference interpreter, without JAX."""

from sjdsl.trace.effects import Effect, effects_of
from sjdsl.trace.episode import Moment, Told, play, tell_of
from sjdsl.trace.rules import Rules

__all__ = ["Effect", "Moment", "Rules", "Told", "effects_of", "play", "tell_of"]
