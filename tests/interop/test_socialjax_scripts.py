"""The released suite's families of scripts: their calls on our games."""

import math
from typing import Any

import jax
import pytest

from sjdsl.interop import socialjax
from sjdsl.interop.socialjax_table import entries
from sjdsl.library.games_folder import games_folder
from tests.interop.socialjax_client import FAMILIES, GAMES, train

TINY = {"NUM_ENVS": 2, "NUM_STEPS": 8, "SEED": 30}
STEPS = 8  # of an episode: each update sees one end


def keywords(game: str, **more: Any) -> dict[str, Any]:
    """Returns the keywords of `make` in the IPPO configuration of a game."""
    asked = GAMES[game]
    given = {**asked["kwargs"], **more, "num_inner_steps": STEPS, "cnn": True, "jit": True}
    if "map" in asked:
        letters = {ours: theirs for theirs, ours in entries()[asked["id"]].letters.items()}
        rows = (games_folder() / "maps" / f"{asked['map']}.txt").read_text().splitlines()
        given["map_ASCII"] = ["".join(letters[letter] for letter in row) for row in rows]
    return given


def assert_learnt(metrics: list[dict[str, float]], names: list[str]) -> None:
    assert len(metrics) == 2
    for metric in metrics:
        assert set(names) <= set(metric)
        assert all(math.isfinite(value) for value in metric.values())


@pytest.mark.parametrize("family", FAMILIES)
def test_the_calls_of_each_family(family: str) -> None:
    kwargs = {
        **FAMILIES[family]["kwargs"],
        "num_inner_steps": STEPS,
        "cnn": True,
        "jit": True,
        "regrow_rate": 0.2,
    }
    metrics = train(family, {"ENV_NAME": "coin_game", "ENV_KWARGS": kwargs, **TINY})
    assert_learnt(metrics, [*FAMILIES[family]["infos"], *GAMES["coins"]["figures"]])
    assert [metric["ends"] for metric in metrics] == [pytest.approx(1 / STEPS)] * 2
    scale = 1 if kwargs["shared_rewards"] else 2
    assert metrics[0]["original_rewards"] != 0 or metrics[1]["original_rewards"] != 0
    if family in ("IPPO", "MAPPO"):  # everybody is paid the sum
        paid = metrics[0]["shaped_rewards"]
        assert paid == pytest.approx(2 * metrics[0]["original_rewards"], abs=1e-6)
        assert metrics[0]["reward"] == pytest.approx(paid, abs=1e-6)
    else:
        assert scale == 2 and metrics[0]["reward"] == pytest.approx(metrics[0]["shaped_rewards"])


@pytest.mark.parametrize("game", [game for game in GAMES if game != "coins"])
def test_the_calls_of_ippo_in_each_game(game: str) -> None:
    sharing = not GAMES[game]["kwargs"]["shared_rewards"]
    config = {"ENV_NAME": GAMES[game]["id"], "ENV_KWARGS": keywords(game), **TINY}
    metrics = train("IPPO", config, sharing, shown=False)
    assert_learnt(metrics, [*FAMILIES["IPPO"]["infos"], *GAMES[game]["figures"]])


def test_where_agents_are_by_the_suites_count() -> None:
    """Its `up` is a larger row. How agents move: `test_moves_follow_the_suites_compass`."""
    env = socialjax.make("coin_game")
    _, state = env.reset(jax.random.key(3))
    heading = int(state.agent_locs[0, 2])
    assert state.agent_locs[:, :2].T.tolist() == [
        cells.tolist() for cells in env.env.cells(state.game)
    ]
    facing = {0: (1, 0), 1: (0, 1), 2: (-1, 0), 3: (0, -1)}[heading]  # the suite's table of steps
    ours = {0: (-1, 0), 1: (0, 1), 2: (1, 0), 3: (0, -1)}[int(state.game.heading[0])]
    assert facing == ours
