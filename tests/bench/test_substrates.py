"""The speed of substrates: a row each, kept as soon as it is measured; no figure is asserted."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from bench.speed.__main__ import main
from bench.speed.stored import read_figures
from bench.speed.substrates import Substrates, measure_substrates, substrate_tasks
from bench.speed.tables import section_of, tables_of
from sjdsl.bench import Task, game_task
from sjdsl.bench.stored import write_figures
from sjdsl.library.substrates import written_substrates
from sjdsl.runtime.env import Environment


@pytest.mark.thorough
def test_a_run_that_is_stopped_keeps_the_rows_it_has(
    meadow_env: Environment, tmp_path: Path
) -> None:
    def tasks() -> Iterator[Task]:
        yield game_task(meadow_env, "first")
        raise KeyboardInterrupt

    kept: list[Substrates] = []
    with pytest.raises(KeyboardInterrupt):
        measure_substrates(tasks(), (1, 2), 1, kept.append, steps=lambda _: 2)
    write_figures(tmp_path / "found.json", kept[-1])
    found = read_figures(tmp_path / "found.json")
    assert found == kept[-1]
    assert section_of(found) == "substrates cpu"
    speeds, costs = tables_of(found)
    (row,) = speeds.rows
    assert row[:3] == ("first", "2", "tokens")
    assert all(" x" in cell for cell in row[3:])
    assert [cells[0] for cells in costs.rows] == ["first"]
    assert [speed.num_envs for speed in kept[-1].speeds] == [1, 2]


def test_substrates_are_called_by_melting_pots_names() -> None:
    known = {entry.name: entry for entry in written_substrates()}
    assert len(known) == 49
    (task,) = substrate_tasks([known["commons_harvest__open"]])
    assert (task.name, task.num_agents) == ("commons_harvest__open", 7)
    assert (
        "Melting Pot has no substrate commons_harvest_open"
        in CliRunner().invoke(main, ["substrates", "commons_harvest_open"]).output
    )
