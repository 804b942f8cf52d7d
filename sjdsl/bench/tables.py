"""Figures as tables of text: the same ones on a screen and on a page."""

import statistics
from collections.abc import Iterable
from typing import NamedTuple

from sjdsl.bench.compilation import Compilation
from sjdsl.bench.sweep import Sweep
from sjdsl.bench.timing import Report, Speed
from sjdsl.bench.training import Training


class Table(NamedTuple):
    """Rows of text under headings; the first `labels` columns are words, the others figures."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int = 1


class Form(NamedTuple):
    """What a row is about."""

    name: str
    num_agents: int
    observation: str


FORM = ("game", "agents", "observation")


def tables_of(found: Report | Sweep | Training) -> tuple[Table, ...]:
    """Returns the tables of what was measured; comparisons only where there are two things to compare."""
    if isinstance(found, Sweep):
        return (sweep_table(found),)
    if isinstance(found, Training):
        return (training_table(found),)
    return tuple(table for table in (speed_table(found), cost_table(found), relation_table(found)) if table.rows)


def notes_of(found: Report | Sweep | Training) -> tuple[str, ...]:
    """Returns what the tables do not say."""
    if isinstance(found, Training):
        return (
            f"a float32 matrix product does {found.flops_per_s / 1e9:.0f} GFLOP/s here: the floor is an update's operations at that speed",
        )
    if isinstance(found, Sweep) or found.device_peak_bytes is None:
        return ()
    return (f"the device held at most {found.device_peak_bytes / 1e9:.3g} GB while all this was measured",)


def speed_table(report: Report) -> Table:
    """Returns one row a form: for each number of environments its speed, the spread of the rounds, and the ratio."""
    numbers = _numbers(report)
    rows = []
    for form, speeds in _by_form(report.speeds).items():
        cells = (f"{thousands(s.env_steps_per_s)} ±{s.spread:.0%} x{s.ratio:.2f}" for s in (speeds[n] for n in numbers))
        rows.append((*_labels(form), *cells))
    title = f"environment steps a second: median of {report.repeats} rounds, spread, ratio to the yardstick round by round"
    return Table(title, (*FORM, *_columns(numbers)), tuple(rows), len(FORM))


def cost_table(report: Report) -> Table:
    """Returns one row a form: what compiling takes, how large one step is, and the memory the loop needs."""
    numbers = _numbers(report)
    steps = {Form(step.name, step.num_agents, step.observation): step for step in report.compilations}
    rows = []
    for form, speeds in _by_form(report.speeds).items():
        memory = (f"{speeds[n].memory_bytes / 1e6:.3g} MB" for n in numbers)
        slowest = max(speed.loop_compile_s for speed in speeds.values())
        rows.append((*_labels(form), *_step_cells(steps.get(form)), f"{slowest:.1f} s", *memory))
    headings = (*FORM, "step compile", "StableHLO lines", "loop compile", *_columns(numbers))
    return Table("one step compiled, its size; the loop compiled, the memory XLA needs for it", headings, tuple(rows), len(FORM))


def relation_table(report: Report) -> Table:
    """Returns how much longer a step takes with one-hot observations, and with a crowd, by game and number of environments."""
    numbers = _numbers(report)
    by_form = _by_form(report.speeds)
    crowds = {form: next(iter(speeds.values())).crowd for form, speeds in by_form.items()}
    own = {(form.name, form.observation): form for form, crowd in crowds.items() if crowd is None}
    rows = []
    for form, speeds in by_form.items():
        tokens = form._replace(observation="tokens")
        if form.observation != "tokens" and tokens in by_form:
            rows.append(
                (f"{form.name}, {form.num_agents} agents: {form.observation} to tokens", *_longer(speeds, by_form[tokens], numbers))
            )
        fewer = own.get((form.name.removesuffix("+crowd"), form.observation))
        if crowds[form] is not None and fewer is not None:
            said = f"{fewer.name}, {form.observation}: {form.num_agents} agents to {fewer.num_agents}"
            rows.append((said, *_longer(speeds, by_form[fewer], numbers)))
    return Table("how many times as long a step takes", ("of what to what", *_columns(numbers)), tuple(rows))


def sweep_table(sweep: Sweep) -> Table:
    """Returns what many values cost in one program, and in one program each."""
    at_once = sweep.num_values * sweep.num_envs
    apart_s = sum(sweep.apart_compile_s) / len(sweep.apart_compile_s)
    measured = len(sweep.apart_compile_s)
    seconds = f"{apart_s * sweep.num_values:.1f} s"
    if measured < sweep.num_values:
        seconds = f"{seconds} extrapolated: {sweep.num_values} x {apart_s:.2f} s, the mean of {measured}"
    rows = (
        ("one program, values as arguments", "1", f"{sweep.together_compile_s:.2f} s", f"{at_once:,}", _rate(sweep.together)),
        ("a program for each value, in turn", f"{sweep.num_values}", seconds, f"{sweep.num_envs:,}", _rate(sweep.apart)),
        ("one program, one constant value", "1", f"{sweep.constant_compile_s:.2f} s", f"{at_once:,}", _rate(sweep.constant)),
    )
    title = f"{sweep.num_values} values of {sweep.param} of {sweep.name}, {sweep.num_envs:,} environments each"
    headings = ("how", "programs", "compile", "envs at once", "env-steps/s")
    return Table(title, headings, rows)


def training_table(training: Training) -> Table:
    """Returns the parts of an update in medians, and how near it is to the least its matrices take."""
    rows = []
    for split in training.splits:
        parts = (split.environments, split.rollout, split.learning, split.update)
        played, acted, learnt, whole = (statistics.median(seconds) for seconds in parts)
        shares = (f"{part / whole:.0%}" for part in (played, acted - played, learnt))
        labels = (split.name, str(split.num_agents), split.network)
        rate = thousands(split.num_envs * split.num_steps / whole)
        floor = split.flops / training.flops_per_s
        rows.append(
            (*labels, f"{split.compile_s:.1f} s", rate, f"{whole:.2f} s", *shares, f"{split.flops / 1e9:.0f}", f"{floor / whole:.0%}")
        )
    sizes = {(split.num_envs, split.num_steps) for split in training.splits}
    each = "; ".join(f"{envs} environments, {steps} steps" for envs, steps in sorted(sizes))
    headings = ("game", "agents", "network", "compile", "env-steps/s", "update", "environments", "acting", "learning", "GFLOP", "floor")
    return Table(f"one update of IPPO: {each}", headings, tuple(rows), 3)


def thousands(rate: float) -> str:
    """Returns `9.48k` or `1,293k`: three digits say all that a timing knows."""
    return f"{rate / 1000:,.0f}k" if rate >= 100_000 else f"{rate / 1000:.3g}k"


def _rate(rates: tuple[float, ...]) -> str:
    middle = sorted(rates)[len(rates) // 2]
    return f"{thousands(middle)} ±{(max(rates) - min(rates)) / 2 / middle:.0%}"


def _numbers(report: Report) -> list[int]:
    return sorted({speed.num_envs for speed in report.speeds})


def _by_form(speeds: Iterable[Speed]) -> dict[Form, dict[int, Speed]]:
    """Returns the speeds by form, then by number of environments."""
    found: dict[Form, dict[int, Speed]] = {}
    for speed in speeds:
        found.setdefault(Form(speed.name, speed.num_agents, speed.observation), {})[speed.num_envs] = speed
    return found


def _columns(numbers: Iterable[int]) -> Iterable[str]:
    return (f"{n:,} env{'s' if n > 1 else ''}" for n in numbers)


def _labels(form: Form) -> tuple[str, str, str]:
    return form.name, str(form.num_agents), form.observation


def _step_cells(step: Compilation | None) -> tuple[str, str]:
    return ("", "") if step is None else (f"{step.compile_s:.1f} s", f"{step.stablehlo_lines:,}")


def _longer(speeds: dict[int, Speed], base: dict[int, Speed], numbers: list[int]) -> Iterable[str]:
    return (f"{base[n].env_steps_per_s / speeds[n].env_steps_per_s:.2f}" for n in numbers)
