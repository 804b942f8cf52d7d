"""Interprets statements that draw random numbers: `chance`, `draw`, `pick` and `match`."""

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter import members
from sjdsl.interpreter.account import Drawn
from sjdsl.interpreter.evaluate import evaluate, members_of, nearest_members
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import Found
from sjdsl.interpreter.state import Value

HALF = 2**31


def chance(statement: ir.Chance, here: Instance) -> Drawn:
    """Returns the branch that happens: one word for the whole chain, each branch its share of what is left."""
    word = here.word(statement.stream, here.number)
    threshold, bounds = 0, []
    for number, branch in enumerate(statement.branches):
        threshold += int(np.float32(HALF - threshold) * _probability(branch.test, here))
        bounds.append(threshold)
        if word >> 1 < threshold:
            return Drawn(statement, here.number, word, number, tuple(bounds), here.names)
    return Drawn(statement, here.number, word, None, tuple(bounds), here.names)


def draw(statement: ir.Draw, here: Instance) -> Drawn:
    """Returns the number or word drawn."""
    word = here.word(statement.stream, here.number)
    return Drawn(statement, here.number, word, _drawn(statement, word, here), names=here.names)


def _drawn(statement: ir.Draw, word: int, here: Instance) -> Value:
    if statement.low is not None and statement.high is not None:
        low, high = evaluate(statement.low, here), evaluate(statement.high, here)
        if statement.type.kind == "real":  # the upper 24 bits: as many as a float32 holds exactly
            low, high = np.float32(low), np.float32(high)
            return np.float32(
                low + np.float32(np.float32(high - low) * np.float32((word >> 8) * 2.0**-24))
            )
        assert 1 <= high - low + 1 <= 65535, (low, high)
        return low + (word * (high - low + 1) >> 32)
    if not statement.weights:
        return statement.words[word * len(statement.words) >> 32]
    values = statement.numbers or statement.words
    running = np.float32(0)
    for value, weight in zip(values[:-1], statement.weights[:-1], strict=True):
        running = np.float32(running + _probability(weight, here))
        if word >> 1 < int(running * np.float32(HALF)):
            return value
    return values[-1]


def _probability(e: ir.Expr, here: Instance) -> np.float32:
    """Returns a probability; what rounding has brought below 0 is 0."""
    return max(np.float32(evaluate(e, here)), np.float32(0))


def picked(
    statement: ir.Pick, all_members: list[Found], here: Instance
) -> list[tuple[Found, Drawn]]:
    """Returns as many members as the statement says, one word and one of those still left for each turn."""
    turns = min(statement.most, members.radix(statement.domain, here.board))
    left = sorted(all_members, key=lambda m: m.number)
    taken: list[tuple[Found, Drawn]] = []
    for turn in range(min(max(0, evaluate(statement.number, here)), len(left))):
        number = here.number * turns + turn
        member, word = here.take(statement.stream, number, left)
        taken.append(
            (member, Drawn(statement, number, word, True, names={**here.names, **member.names}))
        )
    return taken


def matched(statement: ir.Match, here: Instance) -> list[tuple[Found, Found, Drawn]]:
    """Returns all possible pairs in a random order; each is matched if both of its members are still free."""
    rights = members.everybody(statement.right, here.board)
    pairs_in_all = members.everybody(statement.left, here.board) * rights
    ranked: list[tuple[int, int, int, Found, Found]] = []
    for left in members_of(statement.left, here):
        for right in _partners(statement, left, here):
            mine, theirs = (
                members.own_number(d, m, here.board)
                for d, m in ((statement.left, left), (statement.right, right))
            )
            number = here.number * pairs_in_all + mine * rights + theirs
            word = here.word(statement.stream, number)
            ranked.append((-(word >> 1), number, word, left, right))
    taken: set[object] = set()
    pairs: list[tuple[Found, Found, Drawn]] = []
    for _, number, word, left, right in sorted(ranked, key=lambda pair: pair[:2]):
        free = not taken & {left.member, right.member}
        taken |= {left.member, right.member} if free else set()
        names = {**here.names, **left.names, **right.names}
        pairs.append((left, right, Drawn(statement, number, word, free, names=names)))
    return pairs


def _partners(statement: ir.Match, left: Found, here: Instance) -> list[Found]:
    inside = here.binding(left.names)
    if statement.first:
        found = [m for m in nearest_members(statement.right, inside) if m is not None]
    else:
        found = members_of(statement.right, inside)
    return list({m.member: m for m in found if m.member != left.member}.values())
