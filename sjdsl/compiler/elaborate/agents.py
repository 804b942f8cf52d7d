"""Elaborates agents: their number, actions and fields, and what they block."""

from collections.abc import Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.actions import declare_actions, forbids
from sjdsl.compiler.elaborate.fields import one_field
from sjdsl.compiler.elaborate.possible import possible_condition
from sjdsl.compiler.elaborate.scope import ALL_ACTIONS, Scope, Static
from sjdsl.compiler.ir.entity_types import AGENTS


def override_number(
    game: Composition, overrides: dict[str, object], num_agents: int, problems: Problems
) -> None:
    """Adds the size that is the number of agents to the sizes that a caller sets."""
    number = game.number
    if isinstance(number, ast.Path) and not number.steps and number.name.text in game.constants:
        overrides.setdefault(number.name.text, num_agents)
    elif number is not None:
        feature = "another number of agents: `agents` does not name a `size` that says how many"
        problems.add(errors.Unsupported(number.span, feature=feature))


def declare_number(game: Composition, scope: Scope) -> None:
    """Adds the number of agents to the tables."""
    if game.number is not None:
        with scope.problems.skip_if_broken():
            name = "the number of agents"
            scope.static.num_agents = scope.whole(game.number, name, name, 1, limits.MAX_AGENTS)


def declare_agents(game: Composition, scope: Scope) -> None:
    """Adds the actions and fields of the agents to the tables; reports what is missing of them."""
    static = scope.static
    problems = scope.problems
    declare_actions(game, scope)
    if game.moves is not None and game.moves.frame.text not in ("relative", "compass"):
        problems.unknown(game.moves.frame, ("relative", "compass"), "the ways of moving")
    for name, declared in game.agent_fields.items():
        with problems.skip_if_broken(static.broken, Symbol("field", name, "agent")):
            static.agent_fields[name] = one_field(declared, scope, AGENTS)
    span = game.agents_span or game.span
    if game.agents_span is None or game.number is None:
        example = "`agents 2 { acts ... moves relative }`"
        problems.add(errors.MissingPart(span, part="number of agents", example=example))
    elif game.acts is None:
        static.broken.add(ALL_ACTIONS)
        example = "`acts turn_left, ..., stay` in `agents`"
        problems.add(errors.MissingPart(span, part="actions", example=example))


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
    """Returns the shapes whose lanes end at agents, or at those for whom a condition holds."""
    block_nodes: list[ir.Block] = []
    for blocks in game.agent_blocks.values():
        with scope.problems.skip_if_broken():
            for name in blocks.what:
                if name.text == "agents":
                    help_ = (
                        "agents always block each other: no two are on one cell; "
                        "name the shapes whose lanes end at an agent"
                    )
                    raise scope.misused(name, "the agents", "a shape", help_)
            test = None
            if blocks.condition is not None:
                test = possible_condition(blocks.condition, scope)
            block_nodes += blocked(blocks, {AGENTS: test}, scope)
    return tuple(block_nodes)


def blocked(
    blocks: ast.Blocks, tests: Mapping[ir.EntityType, ir.Expr | None], scope: Scope
) -> list[ir.Block]:
    """Returns what cells of a kind, or agents, block: agents, movers or shapes.

    tests: the condition as it is read for movers of a name; as read for agents it is that of
      agents and shapes too.
    """
    static = scope.static
    block_nodes = []
    for name in blocks.what:
        shape = static.shapes.get(name.text)
        if {Symbol("shape", name.text), Symbol("name", name.text)} & static.broken:
            continue
        if shape is not None:
            static.refer(name, Symbol("shape", name.text))
            if shape.see_through:
                problem = f"the shape `{name.text}` sees through everything"
                scope.problems.add(errors.NeverHappens(name.span, problem=problem))
        elif name.text in static.movers:
            static.refer(name, Symbol("name", name.text))
        elif name.text != "agents":
            known = ["agents", *static.movers, *static.shapes]
            scope.problems.unknown(name, known, "what a cell can block")
            continue
        mover = ir.EntityType("mover", (name.text,))
        test = tests[mover] if mover in tests else tests.get(AGENTS)
        block_nodes.append(ir.Block(what=name.text, condition=test, origin=blocks.span))
    return block_nodes
