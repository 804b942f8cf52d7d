"""Formats speeds as tables of text, for the screen and for pages."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from sjdsl.bench.compilation import Compilation
from sjdsl.bench.timing import Report, Speed


class Table(NamedTuple):
    """Rows of text under headings; the first `labels` columns are text, the others figures."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int = 1


class Form(NamedTuple):
    """The label of a row: a game, its number of agents and the form of its observations."""

    name: str
    num_agents: int
    observation: str


FORM = ("game", "agents", "observation")


def speed_tables(report: Report) -> tuple[Table, ...]:
    """Returns the tables of speeds that have rows."""
    tables = (
        speed_table(report),
        processor_table(report),
        cost_table(report),
        relation_table(report),
    )
    return tuple(table for table in tables if table.rows)


def notes_of_speeds(report: Report) -> tuple[str, ...]:
    """Returns notes on tasks that were left out, and on the memory of the device, if it is
    known.
    """
    if report.device_peak_bytes is None:
        return report.left_out
    peak = report.device_peak_bytes / 1e9
    memory = f"the device held at most {peak:.3g} GB while all this was measured"
    return (*report.left_out, memory)


def speed_table(report: Report) -> Table:
    """Returns a row for each form: its speed, the spread of the rounds and the ratio, for each
    number of environments."""
    title = (
        f"environment steps a second: median of {report.repeats} rounds, spread, "
        "ratio to the yardstick round by round"
    )
    return _table_by_number(report, title, speed_cell)


def processor_table(report: Report) -> Table:
    """Returns a row for each form: for each number of environments its steps a second of
    processor time."""
    title = (
        "environment steps a second of processor time, of all cores together: "
        f"median of {report.repeats} rounds"
    )
    return _table_by_number(report, title, lambda speed: thousands(speed.env_steps_per_processor_s))


def _table_by_number(report: Report, title: str, cell: Callable[[Speed], str]) -> Table:
    """Returns a table with a row for each form and a column for each number of environments.

    cell: the text of a speed; it's empty where none was measured.
    """
    numbers = env_numbers(report)
    rows = []
    for form, speeds in grouped(report.speeds).items():
        cells = [cell(speeds[number]) if number in speeds else "" for number in numbers]
        rows.append((*_labels(form), *cells))
    return Table(title, (*FORM, *columns(numbers)), tuple(rows), len(FORM))


def cost_table(report: Report) -> Table:
    """Returns a row for each form: the seconds of compiling, the size of one step, and the memory
    of the loop."""
    numbers = env_numbers(report)
    steps = {
        Form(step.name, step.num_agents, step.observation): step for step in report.compilations
    }
    rows = []
    for form, speeds in grouped(report.speeds).items():
        memory = (f"{speeds[n].memory_bytes / 1e6:.3g} MB" if n in speeds else "" for n in numbers)
        slowest = max(speed.loop_compile_s for speed in speeds.values())
        rows.append((*_labels(form), *_step_cells(steps.get(form)), f"{slowest:.1f} s", *memory))
    headings = (*FORM, "step compile", "StableHLO lines", "loop compile", *columns(numbers))
    title = "compile time and size of one step; compile time of the loop, and the memory it needs"
    return Table(title, headings, tuple(rows), len(FORM))


def relation_table(report: Report) -> Table:
    """Returns how many times as long a step takes with one-hot observations, and with a crowd."""
    numbers = env_numbers(report)
    by_form = grouped(report.speeds)
    crowded = {
        form for form, speeds in by_form.items() if any(speed.crowd for speed in speeds.values())
    }
    # The forms with the game's own number of agents.
    usual = {(form.name, form.observation): form for form in by_form if form not in crowded}
    rows = []
    for form, speeds in by_form.items():
        tokens = form._replace(observation="tokens")
        if form.observation != "tokens" and tokens in by_form:
            label = f"{form.name}, {form.num_agents} agents: {form.observation} to tokens"
            rows.append((label, *_ratios(speeds, by_form[tokens], numbers)))
        fewer = usual.get((form.name.removesuffix("+crowd"), form.observation))
        if form in crowded and fewer is not None:
            agents = f"{form.num_agents} agents to {fewer.num_agents}"
            label = f"{fewer.name}, {form.observation}: {agents}"
            rows.append((label, *_ratios(speeds, by_form[fewer], numbers)))
    headings = ("of what to what", *columns(numbers))
    return Table("how many times as long a step takes", headings, tuple(rows))


def thousands(rate: float) -> str:
    """Returns `9.48k` or `1,293k`: a timing isn't more exact than three digits."""
    return f"{rate / 1000:,.0f}k" if rate >= 100_000 else f"{rate / 1000:.3g}k"


def env_numbers(report: Report) -> list[int]:
    """Returns the numbers of environments that were measured."""
    return sorted({speed.num_envs for speed in report.speeds})


def grouped(speeds: Iterable[Speed]) -> dict[Form, dict[int, Speed]]:
    """Returns the speeds by form, then by number of environments."""
    by_form: dict[Form, dict[int, Speed]] = {}
    for speed in speeds:
        form = Form(speed.name, speed.num_agents, speed.observation)
        by_form.setdefault(form, {})[speed.num_envs] = speed
    return by_form


def columns(numbers: Iterable[int]) -> Iterable[str]:
    """Yields a heading for each number of environments."""
    return ("1 env" if number == 1 else f"{number:,} envs" for number in numbers)


def _labels(form: Form) -> tuple[str, str, str]:
    return form.name, str(form.num_agents), form.observation


def speed_cell(speed: Speed) -> str:
    """Returns a speed, its spread and its ratio: `9.48k ±2% x1.23`."""
    return f"{thousands(speed.env_steps_per_s)} ±{speed.spread:.0%} x{speed.ratio:.2f}"


def _step_cells(step: Compilation | None) -> tuple[str, str]:
    """Returns the compile time of a step and its lines of StableHLO; empty if it wasn't compiled."""
    if step is None:
        return "", ""
    return f"{step.compile_s:.1f} s", f"{step.stablehlo_lines:,}"


def _ratios(speeds: dict[int, Speed], base: dict[int, Speed], numbers: list[int]) -> Iterable[str]:
    """Yields how many times as long a step takes as in `base`, for each number of environments."""
    both = base.keys() & speeds.keys()
    return (
        f"{base[n].env_steps_per_s / speeds[n].env_steps_per_s:.2f}" if n in both else ""
        for n in numbers
    )
