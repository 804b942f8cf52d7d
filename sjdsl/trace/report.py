"""A trace as JSON data for other programs."""

from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Done, Drawn
from sjdsl.interpreter.state import HEADINGS, Cell, Mover
from sjdsl.render.letters import draw
from sjdsl.trace.effects import Effect, Used, plain
from sjdsl.trace.episode import Moment, Told
from sjdsl.trace.lines import Teller, is_shown
from sjdsl.trace.reasons import Explainer, Reason, explainer_of
from sjdsl.trace.rules import Rules


def moment_report(moment: Moment, teller: Teller) -> dict[str, Any]:
    """Returns the start of an episode (`step` null) or a step as JSON has it. `key`: the two words of the key of its draws."""
    game, outcome = teller.board.game, moment.outcome
    return {
        "step": moment.number,
        "key": list(moment.key),
        "actions": [game.agents.actions[action] for action in moment.actions] or None,
        "forbidden": sorted(moment.forbidden),
        "turns": [turn_report(turn, teller) for turn in moment.turns if is_shown(turn, teller.phases)],
        "rewards": None if outcome is None else [float(reward) for reward in outcome.reward],
        "events": None if outcome is None else outcome.events,
        "metrics": None if outcome is None else {name: plain(value) for name, value in outcome.measures.items()},
        "terminated": outcome is not None and outcome.terminated,
        "truncated": outcome is not None and outcome.truncated,
        "picture": draw(teller.looks, teller.board, moment.world),
    }


def turn_report(turn: Told, teller: Teller) -> dict[str, Any]:
    """Returns one turn of the schedule."""
    explainer = explainer_of(turn, teller.board, teller.rules)
    return {"turn": turn.label, "effects": [_effect(effect, teller, explainer) for effect in turn.effects]}


def _effect(effect: Effect, teller: Teller, explainer: Explainer) -> dict[str, Any]:
    owner = effect.owner
    is_heading = effect.sort == "heading"
    return {
        "sort": effect.sort,
        "agent": owner if isinstance(owner, int) else None,
        "mover": [owner.sort, owner.number] if isinstance(owner, Mover) else None,
        "kind": teller.board.kind_of[owner] if isinstance(owner, Cell) else None,
        "cell": plain(owner) if isinstance(owner, Cell) else None,
        "name": effect.name or None,
        "old": HEADINGS[effect.old] if is_heading else plain(effect.old),
        "new": HEADINGS[effect.new] if is_heading else plain(effect.new),
        "by": [_done(done, teller.rules) for done in effect.by],
        "because": [reason_report(reason) for reason in explainer.effect(effect)],
        "random_words": [_used(used) for used in effect.draws],
    }


def reason_report(reason: Reason) -> dict[str, Any]:
    """Returns why something happened: a sentence, its random bits in words, or nothing, and the reasons behind it."""
    return {"text": reason.text, "bits": reason.bits, "because": [reason_report(behind) for behind in reason.because]}


def _statement(statement: ir.Stmt, rules: Rules) -> dict[str, Any]:
    span = statement.origin
    return {"file": span and span.file, "line": span and span.line, "text": rules.text(statement)}


def _done(done: Done, rules: Rules) -> dict[str, Any]:
    names = {name: plain(value) for name, value in done.names.items()}
    return {**_statement(done.statement, rules), "names": names, "draws": [_drawn(drawn, rules) for drawn in done.causes]}


def _drawn(drawn: Drawn, rules: Rules) -> dict[str, Any]:
    """`bounds`: of a chance, of 1, one for each branch up to the one that happened; `share`: what they are compared with."""
    return {
        **_statement(drawn.statement, rules),
        "names": {name: plain(value) for name, value in drawn.names.items()},
        "stream": drawn.statement.stream,
        "number": drawn.number,
        "word": drawn.word,
        "share": (drawn.word >> 1) / 2**31,
        "bounds": [bound / 2**31 for bound in drawn.bounds],
        "result": plain(drawn.result),
    }


def _used(used: Used) -> dict[str, Any]:
    return {"purpose": used.purpose, "stream": used.stream, "number": used.number, "word": used.bits}
