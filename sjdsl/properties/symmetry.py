"""Symmetry of the rules under renumbered agents or movers or a mirrored map: equal rules are symmetric, others are compared by play.

Instead of renumbering the agents, the rules are changed. Everything but `agent.index` and a number for an argument of an action
(`vote(3)`) refers to agents and cells, never to numbers. So a game whose agents swap numbers goes as the game in which these are
the swapped numbers. With movers of one sort it is the same. In the same way a mirrored map under the rules is the map under mirrored
rules. What is drawn stays what it is: a mover that goes one of several ways, all equally likely, goes that one under both.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import mover_sort, movers_named
from sjdsl.compiler.ir.sorts import sort_of
from sjdsl.compiler.ir.traverse import rewrite
from sjdsl.compiler.ir.types import integer, words
from sjdsl.interpreter.evaluation_parts import arguments_of
from sjdsl.interpreter.state import HEADINGS, Outcome, Value, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.interpreter.threefry import Draws
from sjdsl.properties.biased_draws import SameForAll

PAIRS = {"turn_left": "turn_right", "step_left": "step_right"}
SIDES = {**PAIRS, **{b: a for a, b in PAIRS.items()}}
MIRRORED = {"east": "west", "west": "east"}


@dataclass(frozen=True)
class TransformedGame:
    """A game with changed rules, and what the difference is, in words."""

    game: ir.Game
    said: str


def transformed_games(check: ir.Check, game: ir.Game) -> list[TransformedGame]:
    """Returns the games that must play as this one does for it to be symmetric; none if its rules stay equal."""
    (what,) = check.words
    if what == "mirror":
        return list(_mirrored(game))
    return list(_renumbered(game) if what == "agents" else _renumbered_movers(game, what))


def one_sided_action(check: ir.Check, game: ir.Game) -> str:
    """Returns which action the agents can take to one side only, in words, if the check is about the mirror; else nothing."""
    actions = game.agents.actions
    lonely = [a for a in actions if a in SIDES and SIDES[a] not in actions] if check.words[0] == "mirror" else []
    return f"the agents can {lonely[0]}, but not {SIDES[lonely[0]]}" if lonely else ""


def why_symmetric(check: ir.Check, game: ir.Game) -> str:
    """Returns why a game is symmetric for which `transformed_games` gives nothing."""
    (what,) = check.words
    if what == "mirror":
        return "no rule tells left from right"
    sort = "" if what == "agents" else what
    sends = [n for turn in game.schedule for n in ir.walk(turn) if isinstance(n, ir.Send) and n.stay and n.origin is not None]
    sends = [n for n in sends if mover_sort(n.who) == sort]
    but = f" (should free cells run out in line {sends[0].origin.line}, lower numbers come first)" if sends and sends[0].origin else ""
    number = f"the number of a `{sort}`" if sort else "an agent's number"
    return f"no rule reads {number}{but}"


def _of_rules(game: ir.Game, rule: Callable[[Any], Any]) -> ir.Game:
    """Returns a game with everything but the phase `start` rewritten, as symmetry is about steps."""
    return game.model_copy(
        update={
            "schedule": tuple(rewrite(turn, rule) for turn in game.schedule),
            "agents": rewrite(game.agents, rule),
            "kinds": tuple(rewrite(kind, rule) for kind in game.kinds),
        }
    )


def _renumbered(game: ir.Game) -> Iterator[TransformedGame]:
    """Yields the game with two neighbouring numbers swapped: these swaps make up all others."""
    rules = (*game.schedule, game.agents, *game.kinds)
    if not any(_reads_number(n) or _may_name_agents(n) for rule in rules for n in ir.walk(rule)):
        return
    own = _of_rules(game, lambda node: node)
    for first in range(game.agents.number - 1):
        order = list(range(game.agents.number))
        order[first : first + 2] = [first + 1, first]
        actions = _renumbered_actions(game, order)

        def rule(node: Any, order: list[int] = order, actions: dict[int, int] = actions) -> Any:
            match node:
                case ir.Given(type=ir.Type(kind="agent"), value=ir.Number(value=int(number)) as value):
                    new = order[number]
                    return node.model_copy(update={"value": value.model_copy(update={"value": new, "type": integer(new, new, "number")})})
                case ir.Forbid() if {actions[a] for a in node.actions} != set(node.actions):
                    return node.model_copy(update={"actions": tuple(sorted(actions[a] for a in node.actions))})
                case _:
                    return _numbered(node, order) if _reads_number(node) else node

        changed = _of_rules(game, rule)
        if changed != own:
            yield TransformedGame(changed, f"if agents {first} and {first + 1} swapped numbers")


def _renumbered_movers(game: ir.Game, sort: str) -> Iterator[TransformedGame]:
    """Yields the game with two neighbouring numbers of movers of a sort swapped."""
    own, number = _of_rules(game, lambda node: node), movers_named(game, sort).number
    for first in range(number - 1):
        order = [*range(first), first + 1, first, *range(first + 2, number)]

        def rule(node: Any, order: list[int] = order) -> Any:
            return _numbered(node, order) if isinstance(node, ir.Attribute) and _reads_number(node, sort) else node

        changed = _of_rules(game, rule)
        if changed != own:
            yield TransformedGame(changed, f"if {sort} {first} and {first + 1} swapped numbers")


def _may_name_agents(node: ir.Node) -> bool:
    """Returns whether a node can name an agent by a number that is written: `vote(0)`."""
    return isinstance(node, ir.Forbid) or (isinstance(node, ir.Given) and node.type.kind == "agent" and isinstance(node.value, ir.Number))


def _renumbered_actions(game: ir.Game, order: Sequence[int]) -> dict[int, int]:
    """Returns the action that does with the agents' new numbers what each action did: `vote(1)` for `vote(0)` if these two are swapped."""
    found = {number: number for number in range(len(game.agents.actions))}
    for action in game.agents.with_arguments:
        numbers = {arguments_of(action, number): number for number in action.numbers}
        for values, number in numbers.items():
            assert values is not None
            pairs = zip(values, action.arguments, strict=True)
            found[number] = numbers[tuple(order[v] if argument.type.kind == "agent" else v for v, argument in pairs)]
    return found


def _reads_number(node: Any, sort: str = "") -> bool:
    """Returns whether a value depends on the number of an agent: `index`, or an entry of a param by agent; or on that of a mover of a sort."""
    if isinstance(node, ir.At):
        by_agent = isinstance(node.row, ir.ParamRef) and sort_of(node.row.type.by[0]) == "agent" and not isinstance(node.key, ir.Word)
        return by_agent and not sort
    return isinstance(node, ir.Attribute) and node.name == "index" and mover_sort(node.owner) == sort


def _numbered(node: ir.Attribute | ir.At, order: list[int]) -> ir.Case:
    """Returns what an agent would read that had the number that another has."""
    if isinstance(node, ir.Attribute):
        arms = [ir.Arm(low=i, high=i, value=ir.Number(type=node.type, value=number)) for i, number in enumerate(order)]
        return ir.Case(type=node.type, subject=node, arms=tuple(arms), origin=node.origin)
    names = words(node.row.type.by[0])
    values = [node.model_copy(update={"key": ir.Word(type=names, value=names.words[number])}) for number in order]
    index = ir.Attribute(type=integer(0, len(order) - 1), owner=node.key, name="index")
    return ir.Case(
        type=node.type,
        subject=index,
        arms=tuple(ir.Arm(low=i, high=i, value=value) for i, value in enumerate(values)),
        origin=node.origin,
    )


def _mirrored(game: ir.Game) -> Iterator[TransformedGame]:
    actions, width = game.agents.actions, len(game.rows[0])
    other = {i: actions.index(SIDES[a]) for i, a in enumerate(actions) if a in SIDES and SIDES[a] in actions}
    ordered = {n.domain.restriction.shape for n in ir.walk(game) if isinstance(n, ir.First) and isinstance(n.domain.restriction, ir.Near)}

    def rule(node: Any) -> Any:
        match node:
            case ir.Shape() if not _is_even(node, node.name in ordered):
                return node.model_copy(update={"lanes": _flipped(node)})
            case ir.Attribute(name="col"):
                last = ir.Number(type=node.type, value=width - 1)
                return ir.Arithmetic(type=node.type, fn="-", args=(last, node), origin=node.origin)
            case ir.Attribute(name="heading") | ir.FieldRead(held_by="mover", name="heading"):
                return mirrored_heading(node)
            case ir.Set(target=ir.Case(subject=heading)):  # of a mover: that it is written is no reading of it
                return node.model_copy(update={"target": heading, "value": mirrored_heading(node.value)})
            case ir.Along():
                return node.model_copy(update={"heading": mirrored_heading(node.heading)})
            case ir.Chose(action=action) if action in other:
                return node.model_copy(update={"action": other[action]})
            case ir.Forbid() if {other.get(a, a) for a in node.actions} != set(node.actions):
                return node.model_copy(update={"actions": tuple(other.get(a, a) for a in node.actions)})
            case ir.Send(facing="east" | "west" as facing):
                return node.model_copy(update={"facing": MIRRORED[facing]})
            case ir.Shift():
                look = node.facing and MIRRORED.get(node.facing, node.facing)
                way = None if node.heading is None else mirrored_heading(node.heading)
                return node.model_copy(update={"facing": look, "heading": way, "quarters": -node.quarters % 4})
            case _:
                return node

    changed = _of_rules(game, rule).model_copy(update={"shapes": tuple(rewrite(shape, rule) for shape in game.shapes)})
    if changed != _of_rules(game, lambda node: node):
        yield TransformedGame(changed, "if left and right were swapped")


def mirrored_heading(e: ir.Expr) -> ir.Expr:
    """Returns a direction with east for west; of one that is mirrored already, the direction itself."""
    type_ = words(HEADINGS)
    if isinstance(e, ir.Case) and e.subject.type.kind == "word" and e == mirrored_heading(e.subject):
        return e.subject
    arms = [ir.Arm(words=(w,), value=ir.Word(type=type_, value=MIRRORED.get(w, w))) for w in e.type.words]
    return ir.Case(type=type_, subject=e, arms=tuple(arms), origin=e.origin)


def _flipped(shape: ir.Shape) -> tuple[tuple[tuple[int, int], ...], ...]:
    return tuple(tuple((ahead, -right) for ahead, right in lane) for lane in shape.lanes)


def _is_even(shape: ir.Shape, ordered: bool) -> bool:
    """Returns whether a shape is its own mirror image: lane by lane, or cell by cell where neither a lane's end nor an order matters."""
    if shape.see_through and not ordered:
        cells = {cell for lane in shape.lanes for cell in lane}
        return cells == {(ahead, -right) for ahead, right in cells}
    return sorted(shape.lanes) == sorted(_flipped(shape))


def compare_step(
    game: ir.Game, other: ir.Game, world: World, actions: Sequence[int], params: Mapping[str, Value], draws: Draws
) -> list[str]:
    """Takes one step under both rules with the same draws and returns what differs afterwards, in words."""
    same = SameForAll(draws)
    mine, theirs = step(game, world, actions, params, same), step(other, world, actions, params, same)
    found = differences(mine, theirs)
    if action_mask(game, mine[0]) != action_mask(other, theirs[0]):
        found.append("what the agents may do next")
    return found


def differences(mine: tuple[World, Outcome], theirs: tuple[World, Outcome]) -> list[str]:
    """Returns in words where two outcomes of a step differ."""
    (a, outcome), (b, other) = mine, theirs
    found = []
    for agent, (r, s) in enumerate(zip(outcome.reward, other.reward, strict=True)):
        if abs(float(r) - float(s)) > 1e-6 * max(1.0, abs(float(r))):
            found.append(f"the reward of agent {agent}: {float(r):.7g}, and {float(s):.7g}")
    for name, count in outcome.events.items():
        if count != other.events[name]:
            found.append(f"the event {name}: {count}, and {other.events[name]}")
    fields = {**{".".join(k): (v, b.cells[k]) for k, v in a.cells.items()}, **{f"agent.{k}": (v, b.agents[k]) for k, v in a.agents.items()}}
    fields |= {k: (v, b.fields[k]) for k, v in a.fields.items()}
    fields |= {"where the agents are": (a.position, b.position), "their headings": (a.heading, b.heading), "who is away": (a.away, b.away)}
    for sort, mine_now in a.movers.items():
        herd = b.movers[sort]
        fields |= {f"{sort}.{k}": (v, herd.fields[k]) for k, v in mine_now.fields.items()}
        fields |= {f"where each {sort} is": (mine_now.position, herd.position), f"which {sort} is away": (mine_now.away, herd.away)}
    found += [f"{name}: {_few(x)}, and {_few(y)}" for name, (x, y) in fields.items() if x != y]
    if outcome.terminated != other.terminated:
        found.append("whether the episode ends")
    return found


def _few(values: Any) -> str:
    shown = str(values if not isinstance(values, list) else [tuple(v) if isinstance(v, tuple) else v for v in values])
    return shown if len(shown) <= 60 else f"{shown[:57]}..."
