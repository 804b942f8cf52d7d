"""The call of a phase with which an episode or a trial begins, before its first step."""

from sjdsl.compiler import ir
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.program.expressions import DTYPES, Expression, Name, call


def begun(phase: ir.Phase, before: Expression) -> Expression:
    """Returns the state after a phase, in which all agents stay and nothing is earned.

    before: the state before the phase.
    """
    actions = call("jnp.full", Name("NUM_AGENTS"), Name("STAY"), DTYPES["i32"])
    return call(phase.name, before, call("no_outcome"), Name("params"), actions, KEY)[0]
