"""Prints a trace: each step turn by turn, each turn rule by rule."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board
from sjdsl.render.letters import Letters, draw, make_letters
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment, Told
from sjdsl.trace.reasons import Explainer, Reason, explainer_of
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_effect, say_names, say_value

RULE, EFFECT, REASON = "  ", " " * 4, " " * 6


@dataclass(frozen=True)
class Teller:
    """What the lines of a trace need to know. phases: names or labels of those to show, all if empty."""

    board: Board
    rules: Rules
    looks: Letters
    phases: Collection[str] = ()
    agents: frozenset[str] = field(default_factory=frozenset)


def make_teller(board: Board, rules: Rules, phases: Collection[str] = ()) -> Teller:
    """Returns what is needed to tell of a game; variables that stand for agents are told from numbers by it."""
    agents = frozenset(node.name for node in ir.walk(board.game) if isinstance(node, ir.Member) and node.sort.what == "agent")
    return Teller(board, rules, make_letters(board.game), phases, agents)


def is_shown(turn: Told, phases: Collection[str]) -> bool:
    """Returns whether a turn is one of those asked for: by its label `receive(cut)` or its name `receive`."""
    return not phases or turn.label in phases or turn.label.partition("(")[0] in phases


def moment_lines(moment: Moment, teller: Teller) -> Iterator[str]:
    """Yields the lines of the start of an episode or of one step."""
    yield "an episode begins" if moment.number is None else f"step {moment.number}"
    if moment.actions:
        yield f"  actions  {_actions(moment, teller.board.game)}"
    for turn in moment.turns:
        if is_shown(turn, teller.phases):
            yield from turn_lines(turn, teller)
    yield from _outcome(moment)
    yield from (f"    {row}" for row in draw(teller.looks, teller.board, moment.world))
    yield ""


def turn_lines(turn: Told, teller: Teller) -> Iterator[str]:
    """Yields the lines of one turn of the schedule: its rules, what each changed and why; a formula is written out once."""
    found = list(rules_with_effects(turn))
    explainer, told = explainer_of(turn, teller.board, teller.rules), set[Reason]()
    if found:
        yield f"  {turn.label}"
    for rule, together in found:
        if rule is not None:
            yield f"{RULE}  {_rule(rule, teller.rules)}"
        for effect in together:
            yield from _effect_lines(effect, rule, teller, explainer, told)


def rules_with_effects(turn: Told) -> Iterator[tuple[ir.Stmt | None, list[Effect]]]:
    """Yields the rules of a turn in the order in which they come first, each with its effects."""
    found: dict[int, tuple[ir.Stmt | None, list[Effect]]] = {}
    for effect in turn.effects:
        if effect.sort == "moved":  # the places tell
            continue
        rule = effect.by[0].statement if effect.by else None
        found.setdefault(id(rule), (rule, []))[1].append(effect)
    yield from found.values()


def _rule(rule: ir.Stmt, rules: Rules) -> str:
    return f"{rules.place(rule)}  {rules.text(rule)}"


def _effect_lines(effect: Effect, rule: ir.Stmt | None, teller: Teller, explainer: Explainer, told: set[Reason]) -> Iterator[str]:
    names = say_names(effect.by[0], effect.owner, teller.agents, teller.board) if effect.by else ""
    others = dict.fromkeys(teller.rules.place(done.statement) for done in effect.by if done.statement is not rule)
    beside = [*([names] if names else []), *(f"also {place}" for place in others)]
    yield f"{EFFECT}  {say_effect(effect, teller.board)}" + (f"  [{'; '.join(beside)}]" if beside else "")
    for number, reason in enumerate(explainer.effect(effect)):
        yield from reason_lines(reason, told, f"{REASON}  {'and' if number else 'because'} ")
    yield from (f"{REASON}  {text}" for text in _lots(effect, names, teller))


def reason_lines(reason: Reason, told: set[Reason], head: str) -> Iterator[str]:
    """Yields a reason and what is behind it, without what was told before. head: what its line begins with."""
    yield f"{head}{reason.text}"
    deeper = " " * (len(head) - len(head.lstrip()) + 2)
    for behind in reason.because:
        if behind not in told:
            told.add(behind)
            yield from reason_lines(behind, told, deeper)


def _lots(effect: Effect, winner: str, teller: Teller) -> Iterator[str]:
    """Yields who else would have made a change: `a 0 lost the lot to a 2`, with the statement where it is another one."""
    winner = winner or (teller.rules.place(effect.by[0].statement) if effect.by else "")
    for done in effect.lost:
        loser = say_names(done, effect.owner, teller.agents, teller.board)
        other = "" if effect.by and done.statement is effect.by[0].statement else teller.rules.place(done.statement)
        yield f"{', '.join(filter(None, (other, loser)))} lost the lot to {winner}"


def _actions(moment: Moment, game: ir.Game) -> str:
    said = []
    for agent, action in enumerate(moment.actions):
        said.append(f"{agent} {game.agents.actions[action]}{' (forbidden)' if agent in moment.forbidden else ''}")
    return ", ".join(said)


def _outcome(moment: Moment) -> Iterator[str]:
    outcome = moment.outcome
    if outcome is None:
        return
    if any(outcome.reward):
        yield f"  rewards  {', '.join(f'{agent} {float(r):+.7g}' for agent, r in enumerate(outcome.reward) if r)}"
    if outcome.measures:
        yield f"  metrics  {', '.join(f'{name} = {say_value(value)}' for name, value in outcome.measures.items())}"
    if outcome.terminated or outcome.truncated:
        yield f"  the episode ends after step {moment.world.step}"
