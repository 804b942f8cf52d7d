"""Interprets statements that draw random numbers: `chance`, `draw`, `pick` and `match`."""

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter import members
from sjdsl.interpreter.account import Drawn
from sjdsl.interpreter.evaluate import evaluate, members_of, nearest_members
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import Bound
from sjdsl.interpreter.state import Value

HALF = 2**31


def choose_branch(statement: ir.Chance, instance: Instance) -> Drawn:
    """Returns the branch that is performed: one draw for the whole chain.

    The test of a branch is its probability if no branch before it is performed.
    """
    bits = instance.bits(statement.stream, instance.number)
    threshold = 0
    bounds = []
    for number, branch in enumerate(statement.branches):
        threshold += int(np.float32(HALF - threshold) * _probability(branch.test, instance))
        bounds.append(threshold)
        if bits >> 1 < threshold:
            return Drawn(statement, instance.number, bits, number, tuple(bounds), instance.names)
    return Drawn(statement, instance.number, bits, None, tuple(bounds), instance.names)


def draw_value(statement: ir.Draw, instance: Instance) -> Drawn:
    """Returns the number or enum value drawn; of a row, those of its entries."""
    if statement.by is not None:
        return _draw_row(statement, len(statement.by), instance)
    bits = instance.bits(statement.stream, instance.number)
    value = _value_of_bits(statement, bits, instance)
    return Drawn(statement, instance.number, bits, value, names=instance.names)


def _draw_row(statement: ir.Draw, entries: int, instance: Instance) -> Drawn:
    """Returns a row, each of its entries drawn by itself, or dealt from values that are left.

    The bits told are those of the first entry.
    """
    first = instance.number * entries
    all_bits = [instance.bits(statement.stream, first + entry) for entry in range(entries)]
    if statement.different:
        values = _values_to_deal(statement)
        for entry, bits in enumerate(all_bits):
            place = entry + ((bits * (len(values) - entry)) >> 32)
            values[entry], values[place] = values[place], values[entry]
        row = tuple(values[:entries])
    else:
        row = tuple(_value_of_bits(statement, bits, instance) for bits in all_bits)
    return Drawn(statement, first, all_bits[0], row, names=instance.names)


def _values_to_deal(statement: ir.Draw) -> list[Value]:
    """Returns all values that a row of different values can be dealt."""
    if statement.words:
        return list(statement.words)
    return list(range(int(statement.type.low), int(statement.type.high) + 1))


def _value_of_bits(statement: ir.Draw, bits: int, instance: Instance) -> Value:
    """Returns the value that 32 random bits draw: from a range, or one of several by weights."""
    if statement.low is not None and statement.high is not None:
        low = evaluate(statement.low, instance)
        high = evaluate(statement.high, instance)
        if statement.type.kind == "real":
            share = np.float32((bits >> 8) * 2.0**-24)  # a float32 holds 24 bits exactly
            width = np.float32(np.float32(high) - np.float32(low))
            return np.float32(np.float32(low) + np.float32(width * share))
        size = high - low + 1
        assert 1 <= size <= 65535, (low, high)
        return low + ((bits * size) >> 32)
    if not statement.weights:
        place = (bits * len(statement.words)) >> 32
        return statement.words[place]
    values = statement.numbers or statement.words
    cumulative = np.float32(0)
    for value, weight in zip(values[:-1], statement.weights[:-1], strict=True):
        cumulative = np.float32(cumulative + _probability(weight, instance))
        if bits >> 1 < int(cumulative * np.float32(HALF)):
            return value
    return values[-1]


def _probability(e: ir.Expr, instance: Instance) -> np.float32:
    """Returns a probability; one that rounding has brought below 0 is 0."""
    return max(np.float32(evaluate(e, instance)), np.float32(0))


def pick_members(
    statement: ir.Pick, candidates: list[Bound], instance: Instance
) -> list[tuple[Bound, Drawn]]:
    """Returns as many members as the statement says; each turn draws one of those that are left."""
    turns = min(statement.most, members.radix(statement.domain, instance.board))
    left = sorted(candidates, key=lambda member: member.number)
    chosen: list[tuple[Bound, Drawn]] = []
    wanted = evaluate(statement.number, instance)
    for turn in range(min(max(0, wanted), len(left))):
        number = instance.number * turns + turn  # no other turn of any instance has it
        member, bits = instance.take(statement.stream, number, left)
        names = {**instance.names, **member.names}
        chosen.append((member, Drawn(statement, number, bits, True, names=names)))
    return chosen


def match_pairs(statement: ir.Match, instance: Instance) -> list[tuple[Bound, Bound, Drawn]]:
    """Returns all possible pairs in a random order; one is matched if both of its members are free.

    The pair with the largest upper 31 bits comes first.
    """
    board = instance.board
    num_rights = members.population(statement.right, board)
    num_pairs = members.population(statement.left, board) * num_rights
    ranked: list[tuple[int, int, int, Bound, Bound]] = []
    for left in members_of(statement.left, instance):
        left_number = members.number_in_population(statement.left, left, board)
        for right in _partners(statement, left, instance):
            right_number = members.number_in_population(statement.right, right, board)
            number = instance.number * num_pairs + left_number * num_rights + right_number
            bits = instance.bits(statement.stream, number)
            ranked.append((-(bits >> 1), number, bits, left, right))
    taken: set[object] = set()
    pairs: list[tuple[Bound, Bound, Drawn]] = []
    for _, number, bits, left, right in sorted(ranked, key=lambda pair: pair[:2]):
        pair = {left.member, right.member}
        are_free = not taken & pair
        if are_free:
            taken |= pair
        names = {**instance.names, **left.names, **right.names}
        pairs.append((left, right, Drawn(statement, number, bits, are_free, names=names)))
    return pairs


def _partners(statement: ir.Match, left: Bound, instance: Instance) -> list[Bound]:
    """Returns the members that may be matched with `left`, each once."""
    inner = instance.binding(left.names)
    if statement.first:
        rights = [member for member in nearest_members(statement.right, inner) if member]
    else:
        rights = members_of(statement.right, inner)
    partners = {right.member: right for right in rights if right.member != left.member}
    return list(partners.values())
