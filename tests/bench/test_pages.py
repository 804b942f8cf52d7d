"""Figures on pages: tables and marks; no figure is measured here."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import jax
import pytest

from bench.speed.sweep import Sweep
from bench.speed.tables import sweep_table, tables_of
from sjdsl.bench import Compilation, Report, Speed, Task
from sjdsl.bench.markdown import markdown_section, replace_section
from sjdsl.bench.tables import speed_tables
from sjdsl.bench.timing import Round, speed_of

DOCS = Path(__file__).parents[2] / "docs"
MACHINE = {"platform": "cpu", "devices": 1}


def speed(
    name: str,
    num_envs: int,
    rate: float,
    num_agents: int = 2,
    observation: str = "tokens",
    crowd: int | None = None,
) -> Speed:
    figures = (rate, rate * 0.9, rate * 1.1, rate / 1e5, 2.0, 3_000_000 * num_envs, rate / 2)
    return Speed(name, num_agents, observation, crowd, num_envs, *figures)


def test_steps_a_second_of_processor_time() -> None:
    """Of 600 steps in 3 seconds, a processor that others use too worked for 2."""
    busy = Round(600, 3.0, 2.0)
    assert (busy.rate, busy.rate_of_processor) == (200, 300)
    task = Task("meadow", 2, 3, lambda: None, lambda *_: None)  # type: ignore[arg-type, return-value]
    compiled = jax.jit(lambda: 0).lower().compile()
    measured = speed_of(task, 1, [busy] * 3, [busy] * 3, (compiled, 1.0))
    (table,) = [
        table for table in speed_tables(report(measured)) if "processor time" in table.title
    ]
    assert table.rows == (("meadow", "2", "tokens", "0.3k"),)


def report(*speeds: Speed, peak: int | None = None) -> Report:
    return Report(
        MACHINE, 3, speeds, (Compilation("meadow", 2, "tokens", 1.5, 1234, {"sort": 0}),), peak
    )


RACE = report(
    *(speed("yardstick", n, 1e5, 7) for n in (1, 128)),
    *(speed("meadow", n, 2e5) for n in (1, 128)),
    *(speed("meadow", n, 1e5, observation="onehot") for n in (1, 128)),
    *(speed("meadow+crowd", n, 5e4, 20, crowd=20) for n in (1, 128)),
)
SWEEP = Sweep(
    MACHINE,
    "meadow",
    "apple",
    64,
    16,
    2.0,
    (4e5, 5e5, 6e5),
    10,
    (1.0, 3.0),
    (2e5, 2e5, 2e5),
    1.5,
    (5e5, 5e5, 5e5),
)


def test_a_section_of_a_page(golden: Callable[[Path, str], None]) -> None:
    """Speeds, costs and relations of forms, and a sweep, of which few or many compilations are extrapolated."""
    tables = [
        *tables_of(RACE),
        *tables_of(SWEEP),
        sweep_table(Sweep(**{**asdict(SWEEP), "num_values": 2})),
    ]
    text = markdown_section("sjdsl bench", "a machine", ["coins is left out"], tables)
    golden(Path(__file__).with_name("section.txt"), text)
    assert len(tables_of(report(speed("meadow", 1, 1e5)))) == 3, "nothing to compare"


def test_the_guide_quotes_the_tables() -> None:
    """The speeds of the nine games in docs/performance.md are those of all tables, without spreads and ratios."""
    quoted = rows_of_games((DOCS / "performance.md").read_text("utf-8"))
    tables = (DOCS / "research" / "speed_tables.md").read_text("utf-8")
    section = tables.partition("<!-- speed 2 devices cpu -->")[2].partition("Compile time")[0]
    measured = {
        (name, agents, *(cell.split()[0] for cell in cells))
        for name, agents, _, *cells in rows_of_games(section)
    }
    assert len(quoted) == 9
    assert {*quoted} <= measured


def rows_of_games(text: str) -> list[tuple[str, ...]]:
    """Returns the cells of each row of a table that begins with a name and a number of agents."""
    rows = (
        tuple(cell.strip() for cell in line.strip("| ").split("|"))
        for line in text.splitlines()
        if line.startswith("| ")
    )
    return [row for row in rows if len(row) > 2 and row[1].isdigit()]


def test_only_the_text_between_the_marks_is_replaced() -> None:
    page = "before\n<!-- speed cpu -->\nold\n<!-- end speed cpu -->\nafter <!-- speed gpu -->\n<!-- end speed gpu -->\n"
    assert replace_section(page, "speed cpu", r"new \1" + "\n") == page.replace("old", r"new \1")
    assert replace_section(replace_section(page, "speed cpu", ""), "speed cpu", "old\n") == page
    with pytest.raises(ValueError, match="<!-- speed tpu -->"):
        replace_section(page, "speed tpu", "")
