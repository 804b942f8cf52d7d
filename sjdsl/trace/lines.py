"""Prints a trace: each step turn by turn, each turn rule by rule."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board
from sjdsl.render.letters import Letters, draw, make_letters
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment, Told
from sjdsl.trace.reasons import Explainer, Reason, explainer_of
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_effect, say_names, say_owner, say_value

RULE, EFFECT, REASON = "  ", " " * 4, " " * 6
NAMED = 5  # places named where alike changes are told together


@dataclass(frozen=True)
class Teller:
    """What the lines of a trace need to know. phases: names or labels of those to show, all if empty.

    most: how many of alike changes of a rule, and of reasons for one change, are told; None: all.
    """

    board: Board
    rules: Rules
    looks: Letters
    phases: Collection[str] = ()
    agents: frozenset[str] = field(default_factory=frozenset)
    most: int | None = None


def make_teller(board: Board, rules: Rules, phases: Collection[str] = ()) -> Teller:
    """Returns what is needed to tell of a game; variables that stand for agents are told from numbers by it."""
    agents = frozenset(
        node.name
        for node in ir.walk(board.game)
        if isinstance(node, ir.Member) and node.sort.what == "agent"
    )
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
        for alike in [together] if teller.most is None else _alike(together, teller.board):
            shown = alike[: _shown(len(alike), teller.most)]
            for effect in shown:
                yield from _effect_lines(effect, rule, teller, explainer, told)
            if len(shown) < len(alike):
                yield f"{EFFECT}  {_more(alike[len(shown) :], teller.board)}"


def rules_with_effects(turn: Told) -> Iterator[tuple[ir.Stmt | None, list[Effect]]]:
    """Yields the rules of a turn in the order in which they come first, each with its effects."""
    found: dict[int, tuple[ir.Stmt | None, list[Effect]]] = {}
    for effect in turn.effects:
        if effect.sort == "moved":  # the places tell
            continue
        rule = effect.by[0].statement if effect.by else None
        found.setdefault(id(rule), (rule, []))[1].append(effect)
    yield from found.values()


def _shown(number: int, most: int | None) -> int:
    """Returns how many of so many lines are shown: all, if a line about the others would save none."""
    return number if most is None or number <= most + 1 else most


def _alike(effects: Sequence[Effect], board: Board) -> list[list[Effect]]:
    """Returns effects of a rule in groups: of owners of one kind, the same change of a word or condition, any change of a number or place."""
    groups: dict[tuple[object, ...], list[Effect]] = {}
    for effect in effects:
        kind = say_owner(effect.owner, board).split(" ")[0]
        values = tuple(value for value in (effect.old, effect.new) if isinstance(value, str | bool))
        groups.setdefault((kind, effect.sort, effect.name.split("[")[0], values), []).append(effect)
    return list(groups.values())


def _more(effects: Sequence[Effect], board: Board) -> str:
    """Returns a line about changes like those that were told."""
    places = [
        f"{say_owner(effect.owner, board)} {''.join(effect.name.partition('[')[1:])}".strip()
        for effect in effects
    ]
    others = f" and {len(places) - NAMED} others" if len(places) > NAMED else ""
    return f"and {len(effects)} more such changes: {', '.join(places[:NAMED])}{others}"


def _rule(rule: ir.Stmt, rules: Rules) -> str:
    return f"{rules.place(rule)}  {rules.text(rule)}"


def _effect_lines(
    effect: Effect, rule: ir.Stmt | None, teller: Teller, explainer: Explainer, told: set[Reason]
) -> Iterator[str]:
    names = say_names(effect.by[0], effect.owner, teller.agents, teller.board) if effect.by else ""
    others = dict.fromkeys(
        teller.rules.place(done.statement) for done in effect.by if done.statement is not rule
    )
    beside = [*([names] if names else []), *(f"also {place}" for place in others)]
    yield f"{EFFECT}  {say_effect(effect, teller.board)}" + (
        f"  [{'; '.join(beside)}]" if beside else ""
    )
    reasons, lots = explainer.effect(effect), list(_lots(effect, names, teller))
    shown = reasons[: _shown(len(reasons), teller.most)]
    for number, reason in enumerate(shown):
        yield from reason_lines(reason, told, f"{REASON}  {'and' if number else 'because'} ")
    if len(shown) < len(reasons):
        yield f"{REASON}  and for {len(reasons) - len(shown)} more reasons"
    yield from (f"{REASON}  {text}" for text in lots[: _shown(len(lots), teller.most)])
    if len(lots) > _shown(len(lots), teller.most):
        yield f"{REASON}  and {len(lots) - _shown(len(lots), teller.most)} more lost it"


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
        other = (
            ""
            if effect.by and done.statement is effect.by[0].statement
            else teller.rules.place(done.statement)
        )
        yield f"{', '.join(filter(None, (other, loser)))} lost the lot to {winner}"


def _actions(moment: Moment, game: ir.Game) -> str:
    said = []
    for agent, action in enumerate(moment.actions):
        said.append(
            f"{agent} {game.agents.actions[action]}{' (forbidden)' if agent in moment.forbidden else ''}"
        )
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
