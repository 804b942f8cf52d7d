"""Elaborates `hide`: marks, contents or fields of some cells that an observation leaves out.

observe { hide marks on river }   ->   Hidden(what="marks", on="cells", name="river", kinds=("water", "channel"))
"""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.elaborate.seen_conditions import observer_scope

PLANES = ("marks", "content")
FORMS = "`hide marks`, `hide marks on KIND`, `hide marks on agents` or `hide content on agents`"


def hides_others(hide: ast.Hide) -> bool:
    """Returns whether a `hide` is about other agents as a whole."""
    return hide.what.name.text == "other" and not hide.what.steps and hide.on is None


def is_of_a_plane(hide: ast.Hide, static: Static) -> bool:
    """Returns whether a `hide` is about marks, content or other agents, and not about a field."""
    name = hide.what.name.text
    return hides_others(hide) or hide.on is not None or (not hide.what.steps and name in PLANES and name not in static.fields)


def unseen(game: Composition, static: Static, problems: Problems) -> tuple[ir.Hidden, ...]:
    """Returns what of some cells is hidden, as written."""
    found = []
    for observable in game.observables.values():
        if isinstance(observable, ast.Hide) and is_of_a_plane(observable, static):
            with problems.survive():
                found.append(_hidden(observable, static, problems))
    return tuple(found)


def _hidden(hide: ast.Hide, static: Static, problems: Problems) -> ir.Hidden:
    what, on = hide.what.name.text, hide.on
    if hides_others(hide):
        seen = observer_scope("other", "", "", static, problems)
        test = None if hide.condition is None else seen.condition(hide.condition)
        return ir.Hidden(what="others", on="agents", when=test, origin=hide.span)
    if hide.what.steps or what not in PLANES:
        raise problems.fail(errors.WrongType(hide.what.span, wanted="`marks` or `content`", given="something else", help=f"write {FORMS}"))
    if what == "content" and (on is None or on.text != "agents"):
        help = "write `hide content on agents`; `show gate as { floor }` makes cells of one kind look like those of another"
        raise problems.fail(errors.WrongType(hide.span, wanted="`on agents`", given="content of other cells", help=help))
    if on is None or on.text == "agents":
        if hide.condition is not None:
            given = "a condition without a kind of cells"
            raise problems.fail(errors.WrongType(hide.span, wanted="`on KIND` before `when`", given=given, help=f"write {FORMS}"))
        return ir.Hidden(what=what, on="map" if on is None else "agents", origin=hide.span)  # type: ignore[arg-type]
    kinds = static.kinds_of(on.text)
    if kinds is None:
        meant = near(on.text, [*static.kinds, *static.groups, "agents"])
        raise problems.fail(errors.UnknownName(on.span, name=on.text, near=meant))
    static.refer(on, Symbol("name", on.text))
    scope = Scope(static, problems, part="observe").bind("agent", ir.Member(name="agent", sort=ir.Sort("agent")))
    scope = scope.bind(on.text, ir.Member(name=on.text, sort=ir.Sort("cell", kinds)))
    test = None if hide.condition is None else scope.condition(hide.condition)
    return ir.Hidden(what="marks", on="cells", name=on.text, kinds=kinds, when=test, origin=hide.span)
