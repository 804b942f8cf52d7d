"""Damaged games are refused near the damage or have other rules; no file makes the compiler fall over. Thousands: `make damage`."""

from random import Random

import pytest

from tests.damage.campaign import look
from tests.damage.edits import GAMES, KINDS, place
from tests.damage.noise import SORTS, fault_of, noise
from tests.damage.nothing import class_of

EDITS = 3 * len(GAMES) * len(KINDS)
NEAR = 0.95  # share of the answered edits with a place within one line. Source: the aim this language set itself
MESSAGES = 1.2  # a single edit, on average. Ours: measured 1.03, see docs/proof.md
FILES = 40  # of each sort of noise


@pytest.mark.thorough
def test_damaged_games_are_refused_near_the_damage_or_have_other_rules() -> None:
    """One test, so that the edits are looked at once, whatever number of workers there are."""
    looked = [look(number, lowered=False) for number in range(EDITS)]
    answered = [(edited, verdict) for edited, verdict in looked if verdict.found]
    assert [(place(edited), verdict.fault) for edited, verdict in looked if verdict.fault] == []
    assert [
        place(edited)
        for edited, verdict in looked
        if verdict.outcome == "same" and not class_of(edited)
    ] == []
    far = [
        f"{place(edited)}: {verdict.messages[0]}"
        for edited, verdict in answered
        if not verdict.near
    ]
    assert len(far) <= (1 - NEAR) * len(answered), "\n".join(far)
    assert sum(len(verdict.found) for _, verdict in answered) <= MESSAGES * len(answered)


@pytest.mark.parametrize("sort", SORTS)
def test_no_file_makes_the_compiler_fall_over(sort: str) -> None:
    random = Random(sort)
    files = [noise(sort, random) for _ in range(FILES)]
    assert [(data, fault) for data in files if (fault := fault_of(data))] == []
