"""Formats all figures as tables of text, for the screen and for docs/research/speed_tables.md."""

import math
import statistics
from collections.abc import Iterable

from bench.speed.kernels import Kernels
from bench.speed.resuming import Resume
from bench.speed.stored import Figures
from bench.speed.substrates import Substrates
from bench.speed.sweep import Sweep
from bench.speed.training import Split, Training
from sjdsl.bench.tables import FORM, Table, notes_of_speeds, speed_tables, thousands
from sjdsl.bench.timing import Report

TRAINED = ("game", "agents", "network", "algorithm", "sharing")


def tables_of(figures: Figures) -> tuple[Table, ...]:
    """Returns the tables of figures; comparisons only where there is something to compare."""
    match figures:
        case Sweep():
            return (sweep_table(figures),)
        case Training():
            tables = (training_table(figures), hours_table(figures))
            return tuple(table for table in tables if table.rows)
        case Kernels():
            return (kernel_table(figures),)
        case Resume():
            return (resume_table(figures),)
    return speed_tables(figures)


def notes_of(figures: Figures) -> tuple[str, ...]:
    """Returns notes on the tables."""
    match figures:
        case Training():
            floor = (
                f"a float32 matrix product does {figures.flops_per_s / 1e9:.0f} GFLOP/s here: "
                "the floor is an update's operations at that speed"
            )
            return (floor, *(f"left out: {line}" for line in figures.left_out))
        case Kernels():
            share = (
                f"a large copy moves {figures.copied_bytes_per_s / 1e9:,.0f} GB/s here, read and "
                "written: the share is what a step's least bytes would take at that speed"
            )
            return (share,)
        case Report():
            return notes_of_speeds(figures)
    return ()


def section_of(figures: Figures) -> str:
    """Returns the name of the section of a page for these figures.

    Examples are `speed gpu`, `speed 2 devices cpu`, `sweep coins spawn cpu`; for updates
    `training mlp gpu`, and with others than IPPO with shared networks
    `training mlp ippo,mappo shared gpu`.
    """
    match figures:
        case Sweep():
            name = f"sweep {figures.name} {figures.param}"
        case Training():
            networks = _listed(split.network for split in figures.splits)
            algorithms = _listed(split.algorithm for split in figures.splits)
            sharings = _listed(split.sharing for split in figures.splits)
            name = f"training {networks}"
            if (algorithms, sharings) != ("ippo", "shared"):
                name += f" {algorithms} {sharings}"
        case Report() if type(figures) is Report:
            devices = figures.machine["devices"]
            name = "speed" if devices == 1 else f"speed {devices} devices"
        case _:
            names = {Kernels: "kernels", Resume: "resuming", Substrates: "substrates"}
            name = names[type(figures)]
    return f"{name} {figures.machine['platform']}"


def _listed(names: Iterable[str]) -> str:
    """Returns names between commas, each once."""
    return ",".join(dict.fromkeys(names))


def sweep_table(sweep: Sweep) -> Table:
    """Returns the cost of many values in one program, and in a program for each value."""
    at_once = sweep.num_values * sweep.num_envs
    measured = len(sweep.apart_compile_s)
    mean = sum(sweep.apart_compile_s) / measured
    seconds = f"{mean * sweep.num_values:.1f} s"
    if measured < sweep.num_values:
        seconds += f" extrapolated: {sweep.num_values} x {mean:.2f} s, the mean of {measured}"
    rows = (
        (
            "one program, values as arguments",
            "1",
            f"{sweep.together_compile_s:.2f} s",
            f"{at_once:,}",
            _rate(sweep.together),
        ),
        (
            "a program for each value, in turn",
            f"{sweep.num_values}",
            seconds,
            f"{sweep.num_envs:,}",
            _rate(sweep.apart),
        ),
        (
            "one program, one constant value",
            "1",
            f"{sweep.constant_compile_s:.2f} s",
            f"{at_once:,}",
            _rate(sweep.constant),
        ),
    )
    title = (
        f"{sweep.num_values} values of {sweep.param} of {sweep.name}, "
        f"{sweep.num_envs:,} environments each"
    )
    headings = ("how", "programs", "compile", "envs at once", "env-steps/s")
    return Table(title, headings, rows)


def training_table(training: Training) -> Table:
    """Returns the shares of an update's parts, by medians, and that of the least time of its
    matrices.
    """
    rows = []
    for split in training.splits:
        environments = statistics.median(split.environments)
        rollout = statistics.median(split.rollout)
        learning = statistics.median(split.learning)
        update = statistics.median(split.update)
        floor = split.flops / training.flops_per_s
        rows.append(
            (
                *_training_labels(split),
                f"{split.compile_s:.1f} s",
                thousands(split.env_steps_per_s),
                _seconds(update),
                f"{environments / update:.0%}",
                f"{(rollout - environments) / update:.0%}",
                f"{learning / update:.0%}",
                f"{split.flops / 1e9:.3g}",
                f"{floor / update:.0%}",
            )
        )
    headings = (
        *TRAINED,
        "compile",
        "env-steps/s",
        "update",
        "environments",
        "acting",
        "learning",
        "GFLOP",
        "floor",
    )
    return Table(f"one update of {_sizes(training.splits)}", headings, tuple(rows), len(TRAINED))


def hours_table(training: Training) -> Table:
    """Returns the hours of a long run at the speed of the updates; without rows unless `hours_to`
    is set."""
    env_steps = training.hours_to or 0
    rows = []
    for split in training.splits if env_steps else ():
        hours = (
            f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
            for value in split.hours_to(env_steps)
        )
        rows.append((*_training_labels(split), thousands(split.env_steps_per_s), *hours))
    headings = (*TRAINED, "env-steps/s", "hours, median round", "fastest round", "slowest round")
    title = (
        f"hours of training for {env_steps:,} environment steps of one seed, "
        "extrapolated from these updates"
    )
    return Table(title, headings, tuple(rows), len(TRAINED))


def _training_labels(split: Split) -> tuple[str, ...]:
    return split.name, str(split.num_agents), split.network, split.algorithm, split.sharing


def _sizes(splits: Iterable[Split]) -> str:
    """Returns `IPPO, MAPPO: 16 environments, 128 steps; VDN: 32 environments, 1 step`."""
    algorithms: dict[tuple[int, int], dict[str, None]] = {}
    for split in splits:
        algorithms.setdefault((split.num_envs, split.num_steps), {})[split.algorithm.upper()] = None
    return "; ".join(
        f"{', '.join(names)}: {envs} environments, {steps} step{'s' if steps > 1 else ''}"
        for (envs, steps), names in algorithms.items()
    )


def _seconds(seconds: float) -> str:
    """Returns `0.23 s`; of short times three digits, as milliseconds."""
    return f"{seconds:.2f} s" if seconds >= 0.1 else f"{seconds * 1000:.3g} ms"


def kernel_table(kernels: Kernels) -> Table:
    """Returns the kernels and bytes of a step, and its share of the bandwidth of a copy."""
    rows = []
    for step in kernels.steps:
        seconds = statistics.median(step.seconds)
        share = step.least_bytes * step.num_envs / kernels.copied_bytes_per_s / seconds
        rows.append(
            (
                step.name,
                str(step.num_agents),
                step.observation,
                f"{step.num_envs:,}",
                str(step.kernels),
                "" if math.isnan(step.accessed_bytes) else f"{step.accessed_bytes:,.0f}",
                f"{step.least_bytes:,.0f}",
                f"{seconds * 1e6:,.0f} µs",
                thousands(step.num_envs / seconds),
                f"{share:.1%}",
            )
        )
    headings = (
        *FORM,
        "envs",
        "kernels",
        "bytes accessed",
        "least bytes",
        "step",
        "env-steps/s",
        "share of copy bandwidth",
    )
    title = (
        "one step: kernels launched, bytes an environment moves, and the share of the copy "
        "bandwidth"
    )
    return Table(title, headings, tuple(rows), 3)


def resume_table(resume: Resume) -> Table:
    """Returns whether a run that was stopped ended like one that wasn't."""
    same = f"no: {', '.join(resume.different)}" if resume.different else "yes"
    row = (resume.name, str(resume.updates), str(resume.stopped_after), resume.flags, same)
    headings = ("game", "updates", "stopped after", "flags", "same end, bit for bit")
    title = "a training run stopped and resumed, beside one that was never stopped"
    return Table(title, headings, (row,), len(headings))


def _rate(rates: tuple[float, ...]) -> str:
    """Returns the median of the rounds, and half their spread: `12.3k ±2%`."""
    median = sorted(rates)[len(rates) // 2]
    return f"{thousands(median)} ±{(max(rates) - min(rates)) / 2 / median:.0%}"
