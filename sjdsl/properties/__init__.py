"""Puts the promises of a game (`checks`) to the test: proofs, random courses on the interpreter, episodes of the compiled game."""

from sjdsl.properties.instances import Ground
from sjdsl.properties.verdict import Effort, Verdict
from sjdsl.properties.verify_properties import Examination, Report, examine

__all__ = ["Effort", "Examination", "Ground", "Report", "Verdict", "examine"]
