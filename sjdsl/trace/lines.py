"""Prints a trace: each step turn by turn, each turn rule by rule."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board
from sjdsl.render.letters import Letters, draw, make_letters
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment, Turn
from sjdsl.trace.reasons import Explainer, Reason, explainer_of
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_effect, say_names, say_owner, say_value

# Indentation.
RULE = " " * 4
EFFECT = " " * 6
REASON = " " * 8
NAMED = 5  # owners that are named where a line stands for several like changes


@dataclass(frozen=True)
class Teller:
    """How the lines of a trace are written.

    phases: names or labels of those that are shown, all if empty; agents: variables that stand for
    agents, not for numbers.
    most: how many like changes of a rule, and reasons of a change, are written out; None for all.
    """

    board: Board
    rules: Rules
    looks: Letters
    phases: Collection[str] = ()
    agents: frozenset[str] = field(default_factory=frozenset)
    most: int | None = None


def make_teller(board: Board, rules: Rules, phases: Collection[str] = ()) -> Teller:
    """Returns how traces of a game are written."""
    agents = frozenset(
        node.name
        for node in ir.walk(board.game)
        if isinstance(node, ir.Member) and node.entity_type.what == "agent"
    )
    return Teller(board, rules, make_letters(board.game), phases, agents)


def is_shown(turn: Turn, phases: Collection[str]) -> bool:
    """Returns whether the phases have a turn's label, `receive(cut)`, or its name, `receive`."""
    return not phases or turn.label in phases or turn.label.partition("(")[0] in phases


def moment_lines(moment: Moment, teller: Teller) -> Iterator[str]:
    """Yields the lines of the start of an episode or of one step."""
    if moment.number is None:
        yield "an episode begins"
    elif moment.trial is None:
        yield f"step {moment.number}"
    else:
        yield f"trial {moment.trial}, step {moment.number}"
    if moment.actions:
        yield f"  actions  {_actions_text(moment, teller.board.game)}"
    for turn in moment.turns:
        if is_shown(turn, teller.phases):
            yield from turn_lines(turn, teller)
    yield from _outcome_lines(moment)
    for row in draw(teller.looks, teller.board, moment.world):
        yield f"    {row}"
    yield ""


def turn_lines(turn: Turn, teller: Teller) -> Iterator[str]:
    """Yields the lines of one turn: its rules, what each changed, and why.

    What is behind a reason is written out once.
    """
    explainer = explainer_of(turn, teller.board, teller.rules)
    written: set[Reason] = set()
    for number, (rule, effects) in enumerate(rules_with_effects(turn)):
        if number == 0:
            yield f"  {turn.label}"
        if rule is not None:
            yield f"{RULE}{teller.rules.place(rule)}  {teller.rules.text(rule)}"
        for like_effects in [effects] if teller.most is None else _groups(effects, teller.board):
            shown = like_effects[: _num_shown(len(like_effects), teller.most)]
            for effect in shown:
                yield from _effect_lines(effect, rule, teller, explainer, written)
            if len(shown) < len(like_effects):
                yield f"{EFFECT}{_rest_line(like_effects[len(shown) :], teller.board)}"


def rules_with_effects(turn: Turn) -> Iterator[tuple[ir.Stmt | None, list[Effect]]]:
    """Yields the rules of a turn in the order of their first effects, each with its effects."""
    rules: dict[int, tuple[ir.Stmt | None, list[Effect]]] = {}
    for effect in turn.effects:
        if effect.changed != "moved":  # its place changes, too
            rule = effect.by[0].statement if effect.by else None
            _, effects = rules.setdefault(id(rule), (rule, []))
            effects.append(effect)
    yield from rules.values()


def _num_shown(number: int, most: int | None) -> int:
    """Returns how many lines are shown: all, if a line about the others would save none."""
    return number if most is None or number <= most + 1 else most


def _groups(effects: Sequence[Effect], board: Board) -> list[list[Effect]]:
    """Returns the effects of a rule in groups of like ones.

    These have owners of one kind and change one field in the same way, or by any number or place.
    """
    groups: dict[tuple[object, ...], list[Effect]] = {}
    for effect in effects:
        kind = say_owner(effect.owner, board).split(" ")[0]
        name = effect.name.split("[")[0]
        values = tuple(value for value in (effect.old, effect.new) if isinstance(value, str | bool))
        groups.setdefault((kind, effect.changed, name, values), []).append(effect)
    return list(groups.values())


def _rest_line(effects: Sequence[Effect], board: Board) -> str:
    """Returns a line about changes that aren't written out."""
    owners = []
    for effect in effects:
        _, bracket, entry = effect.name.partition("[")
        owners.append(f"{say_owner(effect.owner, board)} {bracket}{entry}".strip())
    others = f" and {len(owners) - NAMED} others" if len(owners) > NAMED else ""
    return f"and {len(effects)} more such changes: {', '.join(owners[:NAMED])}{others}"


def _effect_lines(
    effect: Effect, rule: ir.Stmt | None, teller: Teller, explainer: Explainer, written: set[Reason]
) -> Iterator[str]:
    """Yields one change with its reasons. `written`: the reasons that were written out before."""
    names = say_names(effect.by[0], effect.owner, teller.agents, teller.board) if effect.by else ""
    notes = [names] if names else []
    places = (
        teller.rules.place(done.statement) for done in effect.by if done.statement is not rule
    )
    notes += [f"also {place}" for place in dict.fromkeys(places)]
    line = f"{EFFECT}{say_effect(effect, teller.board)}"
    yield f"{line}  [{'; '.join(notes)}]" if notes else line
    reasons = explainer.effect(effect)
    shown = reasons[: _num_shown(len(reasons), teller.most)]
    for number, reason in enumerate(shown):
        conjunction = "and" if number else "because"
        yield from reason_lines(reason, written, f"{REASON}{conjunction} ")
    if len(shown) < len(reasons):
        yield f"{REASON}and for {len(reasons) - len(shown)} more reasons"
    losers = list(_losers(effect, names, teller))
    num_losers = _num_shown(len(losers), teller.most)
    for text in losers[:num_losers]:
        yield f"{REASON}{text}"
    if num_losers < len(losers):
        yield f"{REASON}and {len(losers) - num_losers} more lost it"


def reason_lines(reason: Reason, written: set[Reason], head: str) -> Iterator[str]:
    """Yields a reason and what is behind it.

    Args:
      written: what was written out before, and isn't again; updated.
      head: what the first line begins with.
    """
    yield f"{head}{reason.text}"
    indent = " " * (len(head) - len(head.lstrip()) + 2)
    for behind in reason.because:
        if behind not in written:
            written.add(behind)
            yield from reason_lines(behind, written, indent)


def _losers(effect: Effect, winner: str, teller: Teller) -> Iterator[str]:
    """Yields who else would have made a change: `a 0 lost the lot to a 2`.

    Before it stands the place of the statement if it is another one.
    """
    statement = effect.by[0].statement if effect.by else None
    if not winner and statement is not None:
        winner = teller.rules.place(statement)
    for done in effect.lost:
        loser = say_names(done, effect.owner, teller.agents, teller.board)
        if done.statement is not statement:
            place = teller.rules.place(done.statement)
            loser = f"{place}, {loser}" if loser else place
        yield f"{loser} lost the lot to {winner}"


def _actions_text(moment: Moment, game: ir.Game) -> str:
    """Returns each agent's action, with a note if it was forbidden."""
    actions = []
    for agent, action in enumerate(moment.actions):
        forbidden = " (forbidden)" if agent in moment.forbidden else ""
        actions.append(f"{agent} {game.agents.actions[action]}{forbidden}")
    return ", ".join(actions)


def _outcome_lines(moment: Moment) -> Iterator[str]:
    """Yields the rewards, the metrics, and whether the episode ends."""
    outcome = moment.outcome
    if outcome is None:
        return
    rewards = [f"{agent} {float(r):+.7g}" for agent, r in enumerate(outcome.reward) if r]
    if rewards:
        yield f"  rewards  {', '.join(rewards)}"
    metrics = [f"{name} = {say_value(value)}" for name, value in outcome.measures.items()]
    if metrics:
        yield f"  metrics  {', '.join(metrics)}"
    if outcome.terminated or outcome.truncated:
        yield f"  the episode ends after step {moment.world.step}"
    if outcome.last_of_trial is not None:
        yield f"  trial {moment.trial} ends after step {outcome.last_of_trial.step}"
