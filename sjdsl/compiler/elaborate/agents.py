"""Elaborates agents: their number, actions and fields, and what they block."""

from collections.abc import Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.actions import declare_actions, forbids
from sjdsl.compiler.elaborate.fields import one_field
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import ALL_ACTIONS, Scope, Static
from sjdsl.compiler.ir.sorts import AGENTS


def override_number(
    game: Composition, overrides: dict[str, object], num_agents: int, problems: Problems
) -> None:
    """Adds to the sizes a caller gives the one that is the number of agents."""
    number = game.number
    if isinstance(number, ast.Path) and not number.steps and number.name.text in game.constants:
        overrides.setdefault(number.name.text, num_agents)
    elif number is not None:
        what = "another number of agents: `agents` does not name a `size` that says how many"
        problems.add(errors.Unsupported(number.span, feature=what))


def declare_number(game: Composition, scope: Scope) -> None:
    """Adds the number of agents to the tables."""
    if game.number is not None:
        with scope.problems.survive():
            what = "the number of agents"
            scope.static.num_agents = scope.whole(game.number, what, what, 1, limits.MAX_AGENTS)


def declare_agents(game: Composition, scope: Scope) -> None:
    """Adds the actions and fields of the agents to the tables, whatever else about the agents is missing, and reports that."""
    static, problems = scope.static, scope.problems
    declare_actions(game, scope)
    if game.moves is not None and game.moves.frame.text not in ("relative", "compass"):
        problems.unknown(game.moves.frame, ("relative", "compass"), "the ways of moving")
    for name, declared in game.agent_fields.items():
        with problems.survive(static.broken, Symbol("field", name, "agent")):
            static.agent_fields[name] = one_field(declared, scope, AGENTS)
    span = game.agents_span or game.span
    if game.agents_span is None or game.number is None:
        problems.add(
            errors.MissingPart(
                span, part="number of agents", example="`agents 2 { acts ... moves relative }`"
            )
        )
    elif game.acts is None:
        static.broken.add(ALL_ACTIONS)
        problems.add(
            errors.MissingPart(
                span, part="actions", example="`acts turn_left, ..., stay` in `agents`"
            )
        )


def build_agents(game: Composition, static: Static, problems: Problems) -> ir.Agents | None:
    """Returns the agents, None if the game does not say how many there are or what they can do."""
    if game.agents_span is None or game.number is None or game.acts is None:
        return None
    return ir.Agents(
        number=static.num_agents,
        actions=static.actions,
        relative=game.moves is None or game.moves.frame.text == "relative",
        fields=tuple(static.agent_fields.values()),
        forbids=forbids(game, Scope(static, problems).with_agent("forbid")),
        with_arguments=tuple(static.with_arguments.values()),
        blocks=_blocks(game, Scope(static, problems).with_agent("blocks")),
        origin=game.agents_span,
    )


def _blocks(game: Composition, scope: Scope) -> tuple[ir.Block, ...]:
    """Returns the shapes whose lanes end at agents, perhaps only at those for whom a condition holds."""
    found: list[ir.Block] = []
    for blocks in game.agent_blocks.values():
        with scope.problems.survive():
            for what in blocks.what:
                if what.text == "agents":
                    help_ = "agents always block each other: no two are on one cell; name the shapes whose lanes end at an agent"
                    raise scope.fail(
                        errors.WrongSort(
                            what.span,
                            name="agents",
                            actual="the agents",
                            wanted="a shape",
                            help=help_,
                        )
                    )
            test = None if blocks.condition is None else scope.condition(blocks.condition)
            if test is not None:
                check_possible(test, scope)
            found += blocked(blocks, {AGENTS: test}, scope)
    return tuple(found)


def blocked(
    blocks: ast.Blocks, tests: Mapping[ir.Sort, ir.Expr | None], scope: Scope
) -> list[ir.Block]:
    """Returns what cells of a kind, or agents, stop: the agents, sorts of movers or shapes by name, where a condition holds.

    tests: the condition as it is asked about movers of a sort; as it is asked about agents it is also asked about the others.
    """
    static, found = scope.static, []
    for what in blocks.what:
        if {Symbol("shape", what.text), Symbol("name", what.text)} & static.broken:
            continue
        if (
            what.text != "agents"
            and what.text not in static.shapes
            and what.text not in static.movers
        ):
            scope.problems.unknown(
                what, ["agents", *static.movers, *static.shapes], "what a cell can block"
            )
            continue
        if what.text != "agents":
            static.refer(what, Symbol("shape" if what.text in static.shapes else "name", what.text))
        if what.text in static.shapes and static.shapes[what.text].see_through:
            scope.problems.add(
                errors.NeverHappens(
                    what.span, problem=f"the shape `{what.text}` sees through everything"
                )
            )
        found.append(
            ir.Block(
                what=what.text,
                condition=tests.get(ir.Sort("mover", (what.text,)), tests.get(AGENTS)),
                origin=blocks.span,
            )
        )
    return found
