"""Twelve small games, each with a fault that only several agents or movers together bring about, and each without it (`planted/`).

With a fixed seed and few trajectories; how often other seeds find each fault is in docs/proof.md: `python -m tests.properties.planted_faults`.
"""

import pytest

from sjdsl.properties import Effort, verify_properties
from sjdsl.properties.monitors import STATES

from .planted_faults import GAMES, planted, trajectories_until_found

FOUND = {  # seed, and trajectories within which it finds the fault
    "bridge": (2, 10),
    "buckets": (0, 10),
    "crates": (2, 10),
    "deer": (2, 6),
    "freeze": (2, 16),
    "gate": (3, 4),
    "herd": (8, 10),
    "lock": (7, 10),
    "market": (0, 8),
    "raft": (1, 5),
    "safe": (0, 10),
    "soup": (0, 8),
}


OWN_MAP = {  # seed with which the fault is soon found on the game's own map: with 120 trajectories, and as many again there
    "bridge": 1,
    "buckets": 0,
    "crates": 1,
    "deer": 2,
    "freeze": 1,
    "gate": 3,
    "herd": 8,
    "lock": 7,
    "market": 0,
    "raft": 1,
    "safe": 0,
    "soup": 0,
}


def test_there_are_twelve() -> None:
    assert len(GAMES) == 12
    assert set(FOUND) == set(OWN_MAP) == set(GAMES)


@pytest.mark.parametrize("game", sorted(FOUND))
def test_the_fault_is_found(game: str) -> None:
    seed, most = FOUND[game]
    assert trajectories_until_found(game, seed, most) is not None


@pytest.mark.parametrize("game", [pytest.param(g, marks=pytest.mark.thorough) if g == "soup" else g for g in GAMES])
def test_the_fault_is_found_on_the_own_map(game: str) -> None:
    """Most are found on a small map first."""
    family = planted(game)
    states = [number for number, check in enumerate(family.own.checks) if check.sort in STATES]
    faulty = [states[1]] if game == "crates" else states[:1]
    (verdict,) = verify_properties(family, Effort(examples=120, episodes=0, tries=0, seed=OWN_MAP[game]), faulty).verdicts
    assert verdict.passed is False
    assert verdict.note is None
    assert verdict.scenario is not None
    assert verdict.scenario.rows == family.own.rows


@pytest.mark.parametrize("game", GAMES)
def test_the_game_without_it_is_not_refuted(game: str) -> None:
    report = verify_properties(planted(game, None), Effort(examples=10, episodes=0))
    assert [v.text for v in report.verdicts if not v.passed] == []
    assert not report.faults
