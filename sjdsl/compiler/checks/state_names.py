"""Checks for name clashes in the compiled state: `a_b.c` and `a.b_c` would become one attribute."""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.ir.names import STATE, state_names


def check_state_names(game: ir.Game, problems: Problems) -> None:
    """Reports declarations that would become the same attribute of the compiled state, or one that every state has."""
    seen: dict[str, str] = dict.fromkeys(STATE, "the language")
    for attribute, node in state_names(game):
        if attribute in seen and node.origin is not None:
            problem = f"the compiled state would have `{attribute}` twice (also of {seen[attribute]})"
            name = getattr(node, "label", "") or getattr(node, "name", attribute)
            problems.add(errors.BadName(node.origin, name=name, what="the name of this", problem=problem))
        seen.setdefault(attribute, f"line {node.origin.line}" if node.origin else "another declaration")
