"""`sjdsl sweep` on a small game: what it lists, prints and writes, and what it refuses before anything is trained."""

import csv
import shlex
from pathlib import Path

import pytest
from command_line import Sjdsl

SMALL = ("num_envs=4", "num_steps=8", "num_epochs=1", "network=mlp", "network_width=4", "total_timesteps=64")
SETS = tuple(part for text in SMALL for part in ("--set", text))
SWEEP = ("sweep", "orchard.sj", "--axis", "param.apple=1,2", *SETS, "--episodes", "2", "--run", "swept")


@pytest.mark.thorough
def test_a_sweep_side_by_side(sjdsl: Sjdsl, folder: Path) -> None:
    """Numbers of a game are numbers without shape."""
    listed = sjdsl(*SWEEP, "--seeds", "2", "--dry-run")
    assert listed.out.splitlines() == [
        "orchard_apple-1  seeds 0 to 1             64 steps each  waiting",
        "orchard_apple-2  seeds 0 to 1             64 steps each  waiting",
        "",
        "2 cells: 2 waiting; at most 256 environment steps left",
    ]
    assert not (folder / "swept").exists()
    shown = sjdsl(*SWEEP, "--seeds", "2", "--together", "2")
    assert shown.status == 0, shown.text
    assert [line for line in shown.err.splitlines() if line.startswith("orchard_apple")][:2] == [
        "orchard_apple-1: training side by side",
        "orchard_apple-2: training side by side",
    ]
    assert "2 of 2 cells are done" in shown.out
    assert "swept/results.csv" in shown.out
    rows = [*csv.DictReader((folder / "swept/results.csv").read_text().splitlines())]
    assert [(row["param.apple"], row["seed"], row["together"]) for row in rows] == [
        *(("1", "0", "2"), ("1", "1", "2"), ("2", "0", "2"), ("2", "1", "2")),
    ]
    for one, two in zip(rows[:2], rows[2:], strict=True):
        for row, apple in ((one, 1.0), (two, 2.0)):
            assert float(row["collective_return"]) == pytest.approx(apple * float(row["event_eaten"]))
    again = sjdsl(*SWEEP, "--seeds", "2", "--dry-run")
    assert again.out.splitlines()[-1] == "2 cells: 2 done; at most 0 environment steps left"
    other = sjdsl(*SWEEP, "--seeds", "3")
    assert other.status == 1
    assert "swept holds another sweep: its cell orchard_apple-1 has seeds 2 there, 3 here" in other.err


def test_a_protocol_of_two_stages_is_listed(sjdsl: Sjdsl) -> None:
    listed = sjdsl("sweep", "orchard.sj", "--protocol", "svo", *SETS, "--run", "swept", "--dry-run")
    assert listed.status == 0, listed.text
    assert listed.out.splitlines()[1].startswith("orchard_reward-svo_svo_weight-0.2_svo_angle-90  seeds 0 to 2")
    assert listed.out.splitlines()[-1] == (
        "then a second stage: 5 cells of angles, at the best weight of the first, with seeds of their own"
    )


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (("orchrd", "--axis", "reward=common", "--run", "swept"), 1, "there is no bundled game `orchrd`"),
        (("orchard.sj", "--axis", "reward=common"), 2, "--run"),
        (("--axis", "reward=common", "--run", "swept"), 2, "GAME"),
        (("orchard.sj", "--run", "swept"), 1, "say what varies: --axis NAME=value,value,… or --protocol"),
        (("orchard.sj", "--axis", "rward=common", "--run", "swept"), 1, "there is no axis `rward`; did you mean `reward`?"),
        (("orchard.sj", "--axis", "param.aple=1", "--run", "swept"), 1, "the game has no number `aple`; did you mean `apple`?"),
        (("orchard.sj", "--axis", "variant=rch", "--run", "swept"), 1, "rich"),
        (("orchard.sj", "--axis", "param.apple=9", "--run", "swept"), 1, "outside 0 .. 5"),
        (("orchard.sj", "--protocol", "exchange", "--reward", "common", "--run", "swept"), 1, "the protocol exchange sets `reward` itself"),
        (("orchard.sj", "--protocol", "svo", "--axis", "svo_weight=1", "--run", "swept"), 1, "the protocol svo sets `svo_weight` itself"),
        (("orchard.sj", "--axis", "reward=common", "--preset", "papr", "--run", "swept"), 1, "unknown preset `papr`"),
        (
            ("orchard.sj", "--axis", "reward=common", "--set", "num_evs=3", "--run", "swept"),
            1,
            "unknown key `num_evs`; did you mean `num_envs`?",
        ),
        (("orchard.sj", "--axis", "reward=comon", "--run", "swept"), 1, "did you mean `common`?"),
        (("orchard.sj", "--axis", "algorithm=ipo", "--run", "swept"), 1, "did you mean `ippo`?"),
        (
            ("orchard.sj", "--axis", "param.apple=1,2", "--param", "apple=3", "--run", "swept"),
            1,
            "`param.apple` is an axis, and is also set for all cells",
        ),
        (
            ("orchard.sj", "--axis", "reward=common", "--param", "apple=3", "--param", "apple=4", "--run", "swept"),
            2,
            "`apple` is given twice",
        ),
        (("orchard.sj", "--axis", "reward=common", *SETS, "--set", "num_envs=8", "--run", "swept"), 2, "`num_envs` is given twice"),
        (("orchard.sj", "--axis", "init_from=nowhere/at_all", "--run", "swept"), 1, "nowhere/at_all"),
    ],
)
def test_what_is_refused_at_once(sjdsl: Sjdsl, folder: Path, arguments: tuple[str, ...], status: int, said: str) -> None:
    shown = sjdsl("sweep", *arguments)
    assert shown.status == status, shown.text
    assert said in shown.err
    assert "loading JAX" not in shown.err
    assert not (folder / "swept").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--set", "num_minibatches=5"), "orchard_apple-1: num_envs x num_steps = 4 x 8 = 32 steps cannot be split"),
        (("--partners", "7=random"), "orchard_apple-1: "),
        (("--run", "orchard.sj"), "orchard.sj is a file, and a sweep is a folder"),
    ],
)
def test_what_is_refused_once_jax_is_there(sjdsl: Sjdsl, folder: Path, arguments: tuple[str, ...], said: str) -> None:
    shown = sjdsl(*SWEEP, *arguments)
    assert shown.status == 1, shown.text
    assert said in shown.err
    assert sjdsl(*SWEEP, *arguments, "--dry-run").err.endswith(shown.err.splitlines()[-1] + "\n")
    assert not (folder / "swept").exists()


@pytest.mark.thorough
def test_the_commands_of_the_pages(sjdsl: Sjdsl, folder: Path) -> None:
    root = Path(__file__).parents[2]
    lines = [line for name in ("docs/sweeps.md", "docs/commands.md") for line in (root / name).read_text("utf-8").splitlines()]
    commands = [shlex.split(line.partition("  #")[0])[1:] for line in lines if line.startswith("sjdsl sweep ")]
    assert len(commands) >= 4
    for arguments in commands:
        shown = sjdsl(*arguments, *(() if "--dry-run" in arguments else ("--dry-run",)))
        assert shown.status == 0, shown.text
    assert not (folder / "runs").exists()
