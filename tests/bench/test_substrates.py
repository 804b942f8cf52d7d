"""The speed of substrates: a row each, kept as soon as it is measured; no figure is asserted."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from sjdsl.bench import Task, game_task
from sjdsl.bench.stored import read_found, write_found
from sjdsl.bench.substrates import Substrates, measure_substrates, substrate_tasks
from sjdsl.bench.tables import tables_of
from sjdsl.cli import run
from sjdsl.cli.bench_everything import section_of
from sjdsl.cli.bench_substrates import chosen
from sjdsl.runtime.env import Environment


def test_a_run_that_is_stopped_keeps_the_rows_it_has(meadow_env: Environment, tmp_path: Path) -> None:
    def tasks() -> Iterator[Task]:
        yield game_task(meadow_env, "first")
        raise KeyboardInterrupt

    kept: list[Substrates] = []
    with pytest.raises(KeyboardInterrupt):
        measure_substrates(tasks(), (1, 2), 1, kept.append, steps=lambda _: 2)
    write_found(tmp_path / "found.json", kept[-1])
    found = read_found(tmp_path / "found.json")
    assert found == kept[-1]
    assert section_of(found) == "substrates cpu"
    (table,) = tables_of(found)
    assert table.headings == ("substrate", "agents", "step compile", "StableHLO lines", "1 env", "2 envs")
    (row,) = table.rows
    assert row[:2] == ("first", "2")
    assert all(" x" in cell for cell in row[4:])
    assert [speed.num_envs for speed in kept[-1].speeds] == [1, 2]


def test_substrates_are_called_by_melting_pots_names() -> None:
    assert [entry.game for entry in chosen(["commons_harvest__open"])] == ["harvest_open"]
    assert len(chosen([])) == 49
    (task,) = substrate_tasks(chosen(["commons_harvest__open"]))
    assert (task.name, task.num_agents) == ("commons_harvest__open", 7)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["commons_harvest_open"], "Melting Pot has no substrate `commons_harvest_open`; did you mean `commons_harvest__open`?"),
        (["coins", "--sweep", "spawn"], "--substrates goes without --sweep"),
        (["coins", "--agents", "4"], "--substrates goes without --agents"),
    ],
)
def test_what_is_refused(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["bench", "--substrates", *arguments]) != 0
    assert said in " ".join(capsys.readouterr().err.split())
