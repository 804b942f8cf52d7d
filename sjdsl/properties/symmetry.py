"""Symmetry of the rules under renumbered agents or movers or a mirrored map: equal rules are symmetric, others are compared by play.

Instead of renumbering the agents, the rules are changed. Everything but `agent.index` and a number for an argument of an action
(`vote(3)`) refers to agents and cells, never to numbers. So a game whose agents swap numbers goes as the game in which these are
the swapped numbers. With movers of one sort it is the same. In the same way a mirrored map under the rules is the map under mirrored
rules. What is drawn stays what it is: a mover that goes one of several ways, all equally likely, goes that one under both.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.queries import body_sort, movers_named
from sjdsl.compiler.ir.sorts import AGENTS, Level
from sjdsl.compiler.ir.types import integer, words
from sjdsl.interpreter.evaluate import arguments_of
from sjdsl.interpreter.state import HEADINGS, Outcome, Value, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.interpreter.threefry import Draws
from sjdsl.properties.biased_draws import SameForAll

PAIRS = {"turn_left": "turn_right", "step_left": "step_right"}
SIDES = {**PAIRS, **{b: a for a, b in PAIRS.items()}}
MIRRORED = {"east": "west", "west": "east"}


@dataclass(frozen=True)
class TransformedGame:
    """A game with changed rules, and what the difference is, in words. `order`: whose entry each agent reads in a table by agent."""

    game: ir.Game
    said: str
    order: tuple[int, ...] = ()

    def params(self, given: Mapping[str, Value]) -> Mapping[str, Value]:
        """Returns the parameters with which the changed rules are played."""
        types = {param.name: param.type for param in self.game.params}
        return {name: _reordered(value, types[name].by, self.order) for name, value in given.items()} if self.order else given


def _reordered(value: Any, by: Sequence[Level], order: Sequence[int]) -> Any:
    """Returns a table whose entries by agent are those of others."""
    if not by:
        return value
    entries = [_reordered(entry, by[1:], order) for entry in value]
    return tuple(entries[i] for i in order) if by[0].sort == "agent" else tuple(entries)


def transformed_games(check: ir.Check, game: ir.Game) -> list[TransformedGame]:
    """Returns the games that must play as this one does for it to be symmetric; none if its rules stay equal."""
    (what,) = check.words
    if what == "mirror":
        rule = _mirroring(game)
        changed = _of_rules(game, rule).model_copy(update={"shapes": tuple(rewrite(shape, rule) for shape in game.shapes)})
        return [TransformedGame(changed, "if left and right were swapped")] if changed != _of_rules(game, lambda node: node) else []
    number = game.agents.number if what == "agents" else movers_named(game, what).number
    return list(_renumbered(game, _sort_of(what), number))


def one_sided_action(check: ir.Check, game: ir.Game) -> str:
    """Returns which action the agents can take to one side only, in words, if the check is about the mirror; else nothing."""
    actions = game.agents.actions
    lonely = [a for a in actions if a in SIDES and SIDES[a] not in actions] if check.words[0] == "mirror" else []
    return f"the agents can {lonely[0]}, but not {SIDES[lonely[0]]}" if lonely else ""


def tells_apart(check: ir.Check, game: ir.Game) -> bool:
    """Returns whether a rule of a step may tell agents (or movers, or left and right) apart. If none does, the game is symmetric.

    What it says of agents that are named by their numbers, `forbid vote(0)`, it says for as many agents as the game has.
    """
    (what,) = check.words
    if what in ("agents", "mirror"):
        reads = what == "agents" and any(_reads_number(n) for n in _nodes(game))
        return reads or bool(transformed_games(check, game))
    return any(_reads_number(n, _sort_of(what)) for n in _nodes(game))


def names_agents(game: ir.Game) -> bool:
    """Returns whether a rule of a step may name agents by numbers that are written."""
    return any(_may_name_agents(n) for n in _nodes(game))


def why_symmetric(check: ir.Check, game: ir.Game) -> str:
    """Returns why a game is symmetric in which no rule of a step tells anything apart, and what that leaves out."""
    (what,) = check.words
    if what == "mirror":
        said, (mirrored, same) = "tells left from right", ([rewrite(game.start, rule) for rule in (_mirroring(game), lambda node: node)])
        told: list[ir.Node] = [game.start] if mirrored != same else []
    else:
        sort = _sort_of(what)
        said = "reads an agent's number" if sort == AGENTS else f"reads the number of a `{sort.name}`"
        told = [n for n in ir.walk(game.start) if _reads_number(n, sort)]
    start = f"; `phase start` does, in line {_line(told[0], game.start)}, and is not part of this" if told else ""
    return f"no rule of a step {said}{start}"


def order_of_sending(check: ir.Check, game: ir.Game) -> tuple[list[ir.Send], list[ir.Send]]:
    """Returns where it matters that lower numbers are sent first: where the cells that fit differ from one to another, and if cells run out."""
    what = check.words[0]
    sends = [n for n in _nodes(game) if isinstance(n, ir.Send) and what != "mirror" and body_sort(n.who) == _sort_of(what)]
    return [n for n in sends if variables_around(n.domain)], [n for n in sends if n.stay]


def _sort_of(what: str) -> ir.Sort:
    """Returns the sort that `symmetric agents` or `symmetric deer` speaks of."""
    return AGENTS if what == "agents" else ir.Sort("mover", (what,))


def _line(node: ir.Node, around: ir.Node) -> int:
    return (node.origin or around.span).line


def _nodes(game: ir.Game) -> Iterator[ir.Node]:
    """Yields all of the rules of a step."""
    for rule in (*game.schedule, game.agents, *game.kinds):
        yield from ir.walk(rule)


def _of_rules(game: ir.Game, rule: Callable[[Any], Any]) -> ir.Game:
    """Returns a game with everything but the phase `start` rewritten, as symmetry is about steps."""
    return game.model_copy(
        update={
            "schedule": tuple(rewrite(turn, rule) for turn in game.schedule),
            "agents": rewrite(game.agents, rule),
            "kinds": tuple(rewrite(kind, rule) for kind in game.kinds),
        }
    )


def _renumbered(game: ir.Game, sort: ir.Sort, number: int) -> Iterator[TransformedGame]:
    """Yields the game with two neighbouring numbers of agents, or of movers of a sort, swapped: these swaps make up all others."""
    nodes, agents = list(_nodes(game)), sort == AGENTS
    if not any(_reads_number(n, sort) or (agents and _may_name_agents(n)) for n in nodes):
        return
    tables = agents and any(_reads_table_by_agent(n) for n in nodes)
    own, drawn = _of_rules(game, lambda node: node), _drawn_numbers(game, sort, number)
    for first in range(number - 1):
        order = [*range(first), first + 1, first, *range(first + 2, number)]
        actions = _renumbered_actions(game, order) if agents else {}

        def rule(node: Any, order: list[int] = order, actions: dict[int, int] = actions) -> Any:
            match node:
                case ir.Given(type=ir.Type(kind="agent"), value=ir.Number(value=int(given)) as value) if agents:
                    new = order[given]
                    return node.model_copy(update={"value": value.model_copy(update={"value": new, "type": integer(new, new, "number")})})
                case ir.Forbid() if {actions.get(a, a) for a in node.actions} != set(node.actions):
                    return node.model_copy(update={"actions": tuple(sorted(actions[a] for a in node.actions))})
                case ir.Attribute(name="index") if body_sort(node.owner) == sort:
                    return _numbered(node, order)
                case ir.Local(name=name) if name in drawn:
                    return _numbered(node, order)
                case _:
                    return node

        changed = _of_rules(game, rule)
        if tables or changed != own:
            named = "agents" if agents else sort.name
            yield TransformedGame(changed, f"if {named} {first} and {first + 1} swapped numbers", tuple(order) if tables else ())


def _drawn_numbers(game: ir.Game, sort: ir.Sort, many: int) -> set[str]:
    """Returns the variables that are compared with numbers of agents (or movers) and are each of these with equal chance: in any order they are."""
    draws = [n for n in _nodes(game) if isinstance(n, ir.Draw)]
    every = [n.name for n in draws if _ends(n)[0] <= 0 and _ends(n)[1] >= many - 1]
    pairs = [pair for n in _nodes(game) if isinstance(n, ir.Compare) for pair in ((n.left, n.right), (n.right, n.left))]
    compared = {b.name for a, b in pairs if isinstance(a, ir.Attribute) and _reads_number(a, sort) and isinstance(b, ir.Local)}
    return {name for name in compared if [n.name for n in draws].count(name) == every.count(name) > 0}


def _ends(draw: ir.Draw) -> tuple[float, float]:
    """Returns between which whole numbers is drawn, if these are written; else between none."""
    match draw:
        case ir.Draw(type=ir.Type(kind="int"), low=ir.Number(value=low), high=ir.Number(value=high), weights=()):
            return low, high
        case _:
            return inf, -inf


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


def _reads_number(node: ir.Node, sort: ir.Sort = AGENTS) -> bool:
    """Returns whether a value depends on the number of an agent: `index`, or a table by agent; or on that of a mover of a sort."""
    if isinstance(node, ir.Attribute):
        return node.name == "index" and body_sort(node.owner) == sort
    return sort == AGENTS and _reads_table_by_agent(node)


def _reads_table_by_agent(node: ir.Node) -> bool:
    return isinstance(node, ir.ParamRef) and any(level.sort == "agent" for level in node.type.by)


def _numbered(node: ir.Attribute | ir.Local, order: Sequence[int]) -> ir.Case:
    """Returns the number of the agent that has the number which is read."""
    arms = [ir.Arm(low=i, high=i, value=ir.Number(type=node.type, value=number)) for i, number in enumerate(order)]
    if isinstance(node, ir.Local):  # nobody has the other numbers that may be drawn
        arms += [ir.Arm(high=-1, value=node), ir.Arm(low=len(order), value=node)]
    return ir.Case(type=node.type, subject=node, arms=tuple(arms), origin=node.origin)


def _mirroring(game: ir.Game) -> Callable[[Any], Any]:
    """Returns what turns a part of the rules into its mirror image."""
    actions, width = game.agents.actions, len(game.rows[0])
    other = {i: actions.index(SIDES[a]) for i, a in enumerate(actions) if a in SIDES and SIDES[a] in actions}
    firsts = [n.domain for n in _nodes(game) if isinstance(n, ir.First)]
    firsts += [n.right for n in _nodes(game) if isinstance(n, ir.Match) and n.first]
    ordered = {domain.restriction.shape for domain in firsts if isinstance(domain.restriction, ir.Near)}

    def rule(node: Any) -> Any:
        match node:
            case ir.Shape() if not _is_even(node, node.name in ordered):
                return node.model_copy(update={"lanes": _flipped(node)})
            case ir.Attribute(name="col"):
                last = ir.Number(type=node.type, value=width - 1)
                return ir.Arithmetic(type=node.type, fn="-", args=(last, node), origin=node.origin)
            case ir.Attribute(name="heading") | ir.FieldRead(held_by=ir.Sort("mover"), name="heading"):
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

    return rule


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
    game: ir.Game, other: TransformedGame, world: World, actions: Sequence[int], params: Mapping[str, Value], draws: Draws
) -> list[str]:
    """Takes one step under both rules with the same draws and returns what differs afterwards, in words."""
    same = SameForAll(draws)
    mine = step(game, world, actions, params, same)
    theirs = step(other.game, world, actions, other.params(params), same)
    found = differences(mine, theirs)
    if action_mask(game, mine[0]) != action_mask(other.game, theirs[0]):
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
