"""Formats figures as tables of text, for the screen and for pages."""

import math
import statistics
from collections.abc import Iterable
from typing import NamedTuple

from sjdsl.bench.compilation import Compilation
from sjdsl.bench.extrapolation import Hours
from sjdsl.bench.kernels import Kernels
from sjdsl.bench.resuming import Resume
from sjdsl.bench.stored import Found
from sjdsl.bench.substrates import Substrates
from sjdsl.bench.sweep import Sweep
from sjdsl.bench.timing import Report, Speed
from sjdsl.bench.training import Training
from sjdsl.bench.training_split import Split


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
TRAINED = ("game", "agents", "network", "algorithm", "sharing")


def tables_of(found: Found) -> tuple[Table, ...]:
    """Returns the tables of what was measured; comparisons only where there are two things to compare."""
    match found:
        case Sweep():
            return (sweep_table(found),)
        case Training():
            return tuple(table for table in (training_table(found), hours_table(found)) if table.rows)
        case Kernels():
            return (kernel_table(found),)
        case Resume():
            return (resume_table(found),)
        case Substrates():
            return (substrates_table(found),)
    return tuple(table for table in (speed_table(found), cost_table(found), relation_table(found)) if table.rows)


def notes_of(found: Found) -> tuple[str, ...]:
    """Returns what the tables do not say."""
    match found:
        case Training():
            rate = f"{found.flops_per_s / 1e9:.0f}"
            return (
                f"a float32 matrix product does {rate} GFLOP/s here: the floor is an update's operations at that speed",
                *(f"left out: {line}" for line in found.left_out),
            )
        case Kernels():
            rate = f"{found.copied_bytes_per_s / 1e9:,.0f}"
            return (
                f"a large copy moves {rate} GB/s here, read and written: the share is what a step's least bytes would take at that speed",
            )
        case Report() if found.device_peak_bytes is not None:
            return (f"the device held at most {found.device_peak_bytes / 1e9:.3g} GB while all this was measured",)
    return ()


def speed_table(report: Report) -> Table:
    """Returns one row a form: for each number of environments its speed, the spread of the rounds, and the ratio."""
    numbers = _numbers(report)
    rows = []
    for form, speeds in _by_form(report.speeds).items():
        rows.append((*_labels(form), *(_speed_cell(speeds.get(number)) for number in numbers)))
    title = f"environment steps a second: median of {report.repeats} rounds, spread, ratio to the yardstick round by round"
    return Table(title, (*FORM, *_columns(numbers)), tuple(rows), len(FORM))


def substrates_table(found: Substrates) -> Table:
    """Returns one row a substrate: what one step takes to compile, its size, and the speed at each number of environments."""
    numbers, steps = _numbers(found), {step.name: step for step in found.compilations}
    rows = []
    for form, speeds in _by_form(found.speeds).items():
        cells = (_speed_cell(speeds.get(n)) for n in numbers)
        step = steps[form.name]
        rows.append((form.name, str(form.num_agents), f"{step.compile_s:.1f} s", f"{step.stablehlo_lines:,}", *cells))
    title = f"environment steps a second: median of {found.repeats} rounds, spread, ratio to the yardstick round by round"
    headings = ("substrate", "agents", "step compile", "StableHLO lines", *_columns(numbers))
    return Table(title, headings, tuple(rows))


def cost_table(report: Report) -> Table:
    """Returns one row a form: what compiling takes, how large one step is, and the memory the loop needs."""
    numbers = _numbers(report)
    steps = {Form(step.name, step.num_agents, step.observation): step for step in report.compilations}
    rows = []
    for form, speeds in _by_form(report.speeds).items():
        memory = (f"{speeds[n].memory_bytes / 1e6:.3g} MB" if n in speeds else "" for n in numbers)
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
        floor = split.flops / training.flops_per_s
        times = (f"{split.compile_s:.1f} s", thousands(split.env_steps_per_s), _seconds(whole), *shares)
        rows.append((*_training_labels(split), *times, f"{split.flops / 1e9:.3g}", f"{floor / whole:.0%}"))
    headings = (*TRAINED, "compile", "env-steps/s", "update", "environments", "acting", "learning", "GFLOP", "floor")
    return Table(f"one update of {_sizes(training.splits)}", headings, tuple(rows), len(TRAINED))


def hours_table(training: Training) -> Table:
    """Returns the hours that a long run would take at the speed of the updates; without rows unless they were asked for."""
    rows = []
    for run in training.hours:
        hours = (f"{value:,.0f}" if value >= 100 else f"{value:.3g}" for value in (run.hours, run.shortest, run.longest))
        rows.append((*_training_labels(run), thousands(run.env_steps_per_s), *hours))
    headings = (*TRAINED, "env-steps/s", "hours, median round", "fastest round", "slowest round")
    title = f"hours of training for {training.hours_to or 0:,} environment steps of one seed, extrapolated from these updates"
    return Table(title, headings, tuple(rows), len(TRAINED))


def _training_labels(trained: Split | Hours) -> tuple[str, ...]:
    return trained.name, str(trained.num_agents), trained.network, trained.algorithm, trained.sharing


def _sizes(splits: Iterable[Split]) -> str:
    """Returns `IPPO, MAPPO: 16 environments, 128 steps; VDN: 32 environments, 1 step`."""
    algorithms: dict[tuple[int, int], dict[str, None]] = {}
    for split in splits:
        algorithms.setdefault((split.num_envs, split.num_steps), {})[split.algorithm.upper()] = None
    return "; ".join(
        f"{', '.join(names)}: {envs} environments, {steps} step{'s' if steps > 1 else ''}" for (envs, steps), names in algorithms.items()
    )


def _seconds(seconds: float) -> str:
    """Returns `0.23 s`; of short times three digits, as milliseconds."""
    return f"{seconds:.2f} s" if seconds >= 0.1 else f"{seconds * 1000:.3g} ms"


def kernel_table(kernels: Kernels) -> Table:
    """Returns what a step launches and moves, and how near it is to the bandwidth of a copy."""
    rows = []
    for step in kernels.steps:
        seconds = statistics.median(step.seconds)
        share = step.least_bytes * step.num_envs / kernels.copied_bytes_per_s / seconds
        labels = (step.name, str(step.num_agents), step.observation, f"{step.num_envs:,}")
        moved = ("" if math.isnan(step.accessed_bytes) else f"{step.accessed_bytes:,.0f}", f"{step.least_bytes:,.0f}")
        rows.append((*labels, str(step.kernels), *moved, f"{seconds * 1e6:,.0f} µs", thousands(step.num_envs / seconds), f"{share:.1%}"))
    headings = (*FORM, "envs", "kernels", "bytes accessed", "least bytes", "step", "env-steps/s", "share of copy bandwidth")
    return Table("one step: kernels launched, bytes an environment moves, and the share of the copy bandwidth", headings, tuple(rows), 3)


def resume_table(resume: Resume) -> Table:
    """Returns whether a run that was stopped ended as one that was not."""
    same = "yes" if not resume.different else f"no: {', '.join(resume.different)}"
    row = (resume.name, str(resume.updates), str(resume.stopped_after), resume.flags, same)
    headings = ("game", "updates", "stopped after", "flags", "same end, bit for bit")
    return Table("a training run stopped and resumed, beside one that was never stopped", headings, (row,), len(headings))


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


def _speed_cell(speed: Speed | None) -> str:
    """Returns a speed, its spread and its ratio; nothing where there was no time to measure it."""
    return "" if speed is None else f"{thousands(speed.env_steps_per_s)} ±{speed.spread:.0%} x{speed.ratio:.2f}"


def _step_cells(step: Compilation | None) -> tuple[str, str]:
    return ("", "") if step is None else (f"{step.compile_s:.1f} s", f"{step.stablehlo_lines:,}")


def _longer(speeds: dict[int, Speed], base: dict[int, Speed], numbers: list[int]) -> Iterable[str]:
    both = base.keys() & speeds.keys()
    return (f"{base[n].env_steps_per_s / speeds[n].env_steps_per_s:.2f}" if n in both else "" for n in numbers)
