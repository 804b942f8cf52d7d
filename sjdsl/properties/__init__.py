"""Tests the checks of a game: proves them, or plays to find counterexamples."""

from sjdsl.properties.instances import GameFamily
from sjdsl.properties.verdict import Effort, Verdict
from sjdsl.properties.verify_properties import Report, Verification, verify_properties

__all__ = ["Effort", "GameFamily", "Report", "Verdict", "Verification", "verify_properties"]
