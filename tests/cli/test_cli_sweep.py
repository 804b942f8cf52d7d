"""`sjdsl sweep` on a small game: what it lists, prints and writes, and what it refuses before anything is trained."""

import csv
from pathlib import Path

import pytest
from command_line import Sjdsl

SMALL = "num_envs=4 num_steps=8 num_epochs=1 network=mlp network_width=4 total_timesteps=64"
SETS = " ".join(f"--set {text}" for text in SMALL.split())
SWEEP = f"sweep orchard.sj --axis param.apple=1,2 {SETS} --episodes 2 --run swept"


@pytest.mark.thorough
def test_a_sweep_over_numbers_of_a_game(sjdsl: Sjdsl, folder: Path) -> None:
    listed = sjdsl(f"{SWEEP} --seeds 2 --dry-run")
    assert listed.out.splitlines() == [
        "orchard_apple-1  seeds 0 to 1             64 steps each  waiting",
        "orchard_apple-2  seeds 0 to 1             64 steps each  waiting",
        "",
        "2 cells: 2 waiting; at most 256 environment steps left",
    ]
    assert not (folder / "swept").exists()
    shown = sjdsl(f"{SWEEP} --seeds 2")
    assert shown.status == 0, shown.text
    assert [line for line in shown.err.splitlines() if line.endswith(": training")] == [
        "orchard_apple-1: training",
        "orchard_apple-2: training",
    ]
    assert "2 of 2 cells are done" in shown.out
    assert "swept/results.csv" in shown.out
    rows = [*csv.DictReader((folder / "swept/results.csv").read_text().splitlines())]
    assert [(row["param.apple"], row["seed"]) for row in rows] == [
        ("1", "0"),
        ("1", "1"),
        ("2", "0"),
        ("2", "1"),
    ]
    for one, two in zip(rows[:2], rows[2:], strict=True):
        for row, apple in ((one, 1.0), (two, 2.0)):
            assert float(row["collective_return"]) == pytest.approx(
                apple * float(row["event_eaten"])
            )
    again = sjdsl(f"{SWEEP} --seeds 2 --dry-run")
    assert again.out.splitlines()[-1] == "2 cells: 2 done; at most 0 environment steps left"
    other = sjdsl(f"{SWEEP} --seeds 3")
    assert other.status == 1
    assert (
        "swept holds another sweep: its cell orchard_apple-1 has config seeds 2 there, 3 here"
        in other.err
    )
