"""Puts the promises of a game (`checks`) to the test: proofs, random courses on the interpreter, episodes of the compiled game."""

from sjdsl.promises.examine import Examination, Report, examine
from sjdsl.promises.ground import Ground
from sjdsl.promises.verdict import Effort, Verdict

__all__ = ["Effort", "Examination", "Ground", "Report", "Verdict", "examine"]
