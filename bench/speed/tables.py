"""Formats all figures as tables of text, for the screen and for docs/performance.md."""

import math
import statistics
from collections.abc import Iterable

from bench.speed.kernels import Kernels
from bench.speed.resuming import Resume
from bench.speed.stored import Found
from bench.speed.substrates import Substrates
from bench.speed.sweep import Sweep
from bench.speed.training import Split, Training
from sjdsl.bench.tables import FORM, Table, notes_of_speeds, speed_tables, thousands
from sjdsl.bench.timing import Report

TRAINED = ("game", "agents", "network", "algorithm", "sharing")


def tables_of(found: Found) -> tuple[Table, ...]:
    """Returns the tables of what was measured; comparisons only where there are two things to compare."""
    match found:
        case Sweep():
            return (sweep_table(found),)
        case Training():
            return tuple(
                table for table in (training_table(found), hours_table(found)) if table.rows
            )
        case Kernels():
            return (kernel_table(found),)
        case Resume():
            return (resume_table(found),)
    return speed_tables(found)


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
        case Report():
            return notes_of_speeds(found)
    return ()


def section_of(found: Found) -> str:
    """Returns the marks of a page between which these figures belong: `speed gpu`, `speed 2 devices cpu`, `sweep coins spawn cpu`;
    of updates `training mlp gpu`, of others than IPPO with shared networks `training mlp ippo,mappo shared gpu`."""
    match found:
        case Sweep():
            what = f"sweep {found.name} {found.param}"
        case Training():
            networks, *learnt = (
                ",".join(dict.fromkeys(getattr(split, name) for split in found.splits))
                for name in ("network", "algorithm", "sharing")
            )
            what = (
                f"training {networks}"
                if learnt == ["ippo", "shared"]
                else f"training {networks} {' '.join(learnt)}"
            )
        case Report() if type(found) is Report:
            devices = found.machine["devices"]
            what = "speed" if devices == 1 else f"speed {devices} devices"
        case _:
            what = {Kernels: "kernels", Resume: "resuming", Substrates: "substrates"}[type(found)]
    return f"{what} {found.machine['platform']}"


def sweep_table(sweep: Sweep) -> Table:
    """Returns what many values cost in one program, and in one program each."""
    at_once = sweep.num_values * sweep.num_envs
    apart_s = sum(sweep.apart_compile_s) / len(sweep.apart_compile_s)
    measured = len(sweep.apart_compile_s)
    seconds = f"{apart_s * sweep.num_values:.1f} s"
    if measured < sweep.num_values:
        seconds = (
            f"{seconds} extrapolated: {sweep.num_values} x {apart_s:.2f} s, the mean of {measured}"
        )
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
        times = (
            f"{split.compile_s:.1f} s",
            thousands(split.env_steps_per_s),
            _seconds(whole),
            *shares,
        )
        rows.append(
            (*_training_labels(split), *times, f"{split.flops / 1e9:.3g}", f"{floor / whole:.0%}")
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
    """Returns the hours of a long run at the speed of the updates; without rows unless `hours_to` is set."""
    rows = []
    for split in training.splits if training.hours_to else ():
        hours = (
            f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
            for value in split.hours_to(training.hours_to or 0)
        )
        rows.append((*_training_labels(split), thousands(split.env_steps_per_s), *hours))
    headings = (*TRAINED, "env-steps/s", "hours, median round", "fastest round", "slowest round")
    title = f"hours of training for {training.hours_to or 0:,} environment steps of one seed, extrapolated from these updates"
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
    """Returns what a step launches and moves, and how near it is to the bandwidth of a copy."""
    rows = []
    for step in kernels.steps:
        seconds = statistics.median(step.seconds)
        share = step.least_bytes * step.num_envs / kernels.copied_bytes_per_s / seconds
        labels = (step.name, str(step.num_agents), step.observation, f"{step.num_envs:,}")
        moved = (
            "" if math.isnan(step.accessed_bytes) else f"{step.accessed_bytes:,.0f}",
            f"{step.least_bytes:,.0f}",
        )
        rows.append(
            (
                *labels,
                str(step.kernels),
                *moved,
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
    return Table(
        "one step: kernels launched, bytes an environment moves, and the share of the copy bandwidth",
        headings,
        tuple(rows),
        3,
    )


def resume_table(resume: Resume) -> Table:
    """Returns whether a run that was stopped ended as one that was not."""
    same = "yes" if not resume.different else f"no: {', '.join(resume.different)}"
    row = (resume.name, str(resume.updates), str(resume.stopped_after), resume.flags, same)
    headings = ("game", "updates", "stopped after", "flags", "same end, bit for bit")
    return Table(
        "a training run stopped and resumed, beside one that was never stopped",
        headings,
        (row,),
        len(headings),
    )


def _rate(rates: tuple[float, ...]) -> str:
    middle = sorted(rates)[len(rates) // 2]
    return f"{thousands(middle)} ±{(max(rates) - min(rates)) / 2 / middle:.0%}"
