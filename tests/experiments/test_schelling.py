"""Schelling diagrams of games whose payoffs are known: exact figures, the right slots, and a stopped one that goes on."""

import json
from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array
from small_games import OTHER, STAY, matrix_game, public_goods, threshold_goods

from sjdsl.experiments import ExperimentError, schelling_diagram
from sjdsl.experiments.lineups import orders_of, play_key
from sjdsl.experiments.playing import Experiment, play_experiment
from sjdsl.experiments.schelling import plan_diagram, play_diagram
from sjdsl.trainers import evaluate

STEPS = 4
# S, R, P, T a step, and what they make.
MATRICES = {
    None: ((0, 3, 1, 5), "dilemma", "fear and greed"),
    "stag_hunt": ((0, 4, 1, 3), "dilemma", "fear"),
    "chicken": ((1, 3, 0, 4), "dilemma", "greed"),
    "harmony": ((2, 4, 1, 3), "no dilemma", "neither"),
    "deadlock": ((0, 1, 2, 3), "no dilemma", "fear and greed"),
}


@pytest.mark.parametrize(
    "variant",
    [
        None,
        "stag_hunt",
        *(pytest.param(v, marks=pytest.mark.thorough) for v in ("chicken", "harmony", "deadlock")),
    ],
)
def test_matrix_games_exactly(variant: str | None) -> None:
    (s, r, p, t), outcome, shape = MATRICES[variant]
    found = schelling_diagram(matrix_game(variant), STAY, OTHER, episodes=3)
    for figures, payoffs in ((found.cooperating, (s, r)), (found.defecting, (p, t))):
        assert [(figure.low, figure.mean, figure.high) for figure in figures] == [
            (STEPS * payoff,) * 3 for payoff in payoffs
        ]
    assert [figure.mean for figure in found.everybody] == [
        STEPS * p,
        STEPS * (s + t) / 2,
        STEPS * r,
    ]
    exact = {"A": r - p, "B": r - s, "fear": p - s, "greed": t - r}
    assert {
        name: (figure.low, figure.mean, figure.high) for name, figure in found.contrasts.items()
    } == {name: (STEPS * value,) * 3 for name, value in exact.items()}
    assert (found.verdict.outcome, found.verdict.shape, found.verdict.wanted) == (
        outcome,
        shape,
        None,
    )
    assert [sign for _, sign in found.preferences] == [
        "defect" if value > 0 else "cooperate" for value in (p - s, t - r)
    ]


CROWDS = [3, *(pytest.param(players, marks=pytest.mark.thorough) for players in (2, 4, 5, 6, 7, 8))]


@pytest.mark.parametrize("players", CROWDS)
def test_linear_public_goods_exactly(players: int) -> None:
    """C(l) = r (l + 1) / N - 1 and D(l) = r l / N a step, of two steps: a dilemma exactly if 1 < r < N, with the borders."""
    for r in (0.5, 1.0, (1 + players) / 2, float(players), players + 1.0):
        env = public_goods(players)
        found = schelling_diagram(
            env.with_params(replace(env.params, multiplier=jnp.float32(r))), STAY, OTHER, episodes=2
        )
        rounding = (
            2 * max(r, 1) * 4 * 2**-24
        )  # of float32, in two steps: 1 / N, the share, the subtraction, the sum
        exact = pytest.approx(
            [2 * (r * (others + 1) / players - 1) for others in range(players)], rel=0, abs=rounding
        )
        assert [figure.mean for figure in found.cooperating] == exact, r
        exact = pytest.approx(
            [2 * r * others / players for others in range(players)], rel=0, abs=rounding
        )
        assert [figure.mean for figure in found.defecting] == exact, r
        assert [figure.high - figure.low for figure in found.everybody] == [0.0] * (players + 1)
        assert found.verdict.outcome == ("dilemma" if 1 < r < players else "no dilemma"), r
        assert found.verdict.shape == ("fear and greed" if r < players else "neither"), r
        assert [sign for _, sign in found.preferences] == [
            "defect" if r < players else "equal" if r == players else "cooperate"
        ] * players


@pytest.mark.parametrize("players", CROWDS)
def test_threshold_public_goods_exactly(players: int) -> None:
    """Everybody has b where k agents at least have paid c: the lines cross only at l = k - 1, where one more payment is the one that is missing."""
    b, c = 4, 1
    for k in range(1, players + 1):
        env = threshold_goods(players)
        found = schelling_diagram(
            env.with_params(replace(env.params, needed=jnp.int32(k))), STAY, OTHER, episodes=2
        )
        assert [figure.mean for figure in found.cooperating] == [
            2 * (b * (others + 1 >= k) - c) for others in range(players)
        ], k
        assert [figure.mean for figure in found.defecting] == [
            2 * b * (others >= k) for others in range(players)
        ], k
        assert [sign for _, sign in found.preferences] == [
            "cooperate" if others == k - 1 else "defect" for others in range(players)
        ], k
        assert found.verdict.outcome == ("no dilemma" if k == 1 else "dilemma"), (
            "where one who pays is enough, all who pay have no more"
        )
        assert (
            found.verdict.shape
            == {(False, False): "fear and greed", (False, True): "fear", (True, False): "greed"}[
                k == 1, k == players
            ]
        )


def test_what_a_cooperator_earns_is_in_the_cooperators_line() -> None:
    """Each is paid by its number, more where it gives, less where it keeps: a slot in the wrong line would show."""
    env, episodes, seed = public_goods(4, ranked=1.0), 6, 3
    found = schelling_diagram(env, STAY, OTHER, episodes=episodes, seed=seed)
    orders = orders_of(seed, 0, episodes, 4)
    assert len({tuple(order) for order in orders}) > 1
    for k in range(5):
        for episode, order in enumerate(orders):
            share = 2 * k / 4
            givers = [2 * (share + agent - 1) for agent in order[:k]]
            keepers = [2 * (share - 100 * agent) for agent in order[k:]]
            of_givers, of_keepers = (
                found.returns.cooperators[k, 0, episode],
                found.returns.defectors[k, 0, episode],
            )
            assert np.isnan(of_givers) if k == 0 else of_givers == np.mean(givers)
            assert np.isnan(of_keepers) if k == 4 else of_keepers == np.mean(keepers)
            assert found.returns.everybody[k, 0, episode] == np.mean(givers + keepers)


def test_a_policy_against_itself_is_its_evaluation() -> None:
    """In each line-up the same episodes, which are those that `evaluate` plays."""
    env = public_goods(3, ranked=1.0)
    found = schelling_diagram(env, "random", "random", episodes=5, seed=7)
    played = evaluate(
        env,
        jax.jit(lambda key, _: jax.random.randint(key, (3,), 0, 2, np.int32)),
        play_key(7, 0),
        5,
    )
    for k in range(4):
        np.testing.assert_array_equal(
            found.returns.everybody[k, 0], played.returns.mean(axis=1, dtype=np.float64)
        )
    assert len(set(found.returns.everybody[0, 0])) > 1


def test_figures_are_in_the_files(tmp_path: Path) -> None:
    found = schelling_diagram(matrix_game(), STAY, OTHER, episodes=2, folder=tmp_path / "diagram")
    stored = json.loads((tmp_path / "diagram/schelling.json").read_text())
    assert stored["format"] == 1
    assert (stored["game"]["name"], stored["game"]["hash"]) == ("matrix_game", matrix_game().hash)
    assert stored["returns"]["cooperators"] == [[[None, None]], [[0.0, 0.0]], [[12.0, 12.0]]]
    assert stored["returns"]["defectors"] == [[[4.0, 4.0]], [[20.0, 20.0]], [[None, None]]]
    assert stored["C"] == {"mean": [0.0, 12.0], "low": [0.0, 12.0], "high": [0.0, 12.0]}
    assert stored["D-C"]["preferred"] == ["defect", "defect"]
    assert stored["contrasts"]["greed"]["low"] == 8.0
    assert (stored["verdict"]["outcome"], stored["verdict"]["shape"]) == (
        "dilemma",
        "fear and greed",
    )
    assert (stored["unit"], stored["units"]) == ("episode", 2)
    assert stored["keys"] == [[int(word) for word in jax.random.key_data(play_key(0, 0))]]
    assert (tmp_path / "diagram/schelling.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / "diagram/schelling.svg").read_text()
    assert found.population == "2 episodes, of these policies only"


def test_another_experiment_is_refused_in_the_folder(tmp_path: Path) -> None:
    plan = plan_diagram(matrix_game(), "stay", OTHER, 2, 0)
    play_diagram(plan, tmp_path / "diagram", lambda _: None)
    changed = {
        "episodes 2 there, 3 here": plan_diagram(matrix_game(), "stay", OTHER, 3, 0),
        "seed 0 there, 1 here": plan_diagram(matrix_game(), "stay", OTHER, 2, 1),
        "its policies differ": plan_diagram(matrix_game(), "random", OTHER, 2, 0),
        "game hash": plan_diagram(matrix_game("chicken"), "stay", OTHER, 2, 0),
    }
    for message, other in changed.items():
        with pytest.raises(ExperimentError, match=message):
            play_diagram(other, tmp_path / "diagram", lambda _: None)


def test_a_function_of_python_is_known_by_what_it_does() -> None:
    """Across processes, where names begin anew: the same program has the same digest, with another number in it another."""

    def digest(*numbers: int) -> str | None:
        def mine(key: Array, observation: Array) -> Array:
            del key, observation
            return jnp.asarray(numbers, jnp.int32)

        return plan_diagram(matrix_game(), "stay", mine, 2, 0).pools[1].players[0].digest

    assert digest(0, 0) == digest(0, 0)
    assert len({digest(0, 0), digest(0, 1), digest(1, 1), None}) == 4


def test_returns_that_are_not_finite_are_refused() -> None:
    from tests.trainers.probes import endless_riches

    env = endless_riches()
    experiment = Experiment(
        env, plan_diagram(env, STAY, OTHER, 1, 0).pools, ((0, 0),), 1, 0, permuted=False
    )
    with pytest.raises(
        ExperimentError, match="the return of agent 0 in episode 0 of line-up 1 is not finite"
    ):
        play_experiment(experiment, lambda _: None)
