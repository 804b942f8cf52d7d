"""`sjdsl bench`: measures the speed of games, beside a hand-written game in the same process."""

import shlex
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli import bench_substrates
from sjdsl.cli.bench_devices import check_devices, divide_cpu
from sjdsl.cli.bench_everything import Stored, measure_all, read_all, speed_section
from sjdsl.cli.bench_games import choose_tasks
from sjdsl.cli.bench_options import OBSERVATIONS, Agents, Counts, Quoting, Words, flat, refuse_others
from sjdsl.cli.bench_training import Asked, asked_of, plan_training, training_options, with_hours
from sjdsl.cli.game_file import variant_option
from sjdsl.cli.stages import stages
from sjdsl.games_folder import main_games

if TYPE_CHECKING:
    from sjdsl.bench import Task
    from sjdsl.bench.stored import Found
    from sjdsl.cli.bench_output import Outputs
    from sjdsl.runtime.env import Encoding

Planned = tuple[str, Callable[[Callable[[str], object]], Any]]  # which section of a page, and the measurement
RACED = (1, 128, 1024, 4096)  # environments
SWEPT = (16,)  # of each value
OF_STORED = "--from", ("stored", "hours", "json_file", "page", "plots")  # parameters that it takes notice of
OF_SUBSTRATES = "--substrates", ("games", "substrates", "envs", "repeats", "steps", "json_file", "page")


@click.command("bench", cls=Quoting)
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option(
    "--envs",
    type=Counts(),
    help="Numbers of environments at once: 1,128,1024,4096; in a sweep, of each value: 16; in training: 16, of vdn 32.",
)
@click.option(
    "--observation",
    "observations",
    type=Words(OBSERVATIONS),
    multiple=True,
    help="Forms of observations: tokens (the default), onehot, or tokens,onehot.",
)
@click.option("--agents", type=Agents(), default="own", show_default=True, help="Numbers of agents, such as own,20.")
@click.option(
    "--devices",
    type=click.IntRange(min=1),
    metavar="N",
    default=1,
    show_default=True,
    help="Split the environments over N devices: GPUs, or parts of the CPU with a core each.",
)
@click.option("--repeats", type=click.IntRange(min=1), metavar="N", default=5, show_default=True, help="Rounds of timings.")
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    metavar="N",
    help="Steps of one timing; by default about 40,000 environment steps in all. In training: steps of a rollout; 128, of vdn 1.",
)
@click.option(
    "--sweep", metavar="PARAM", help="Instead: a sweep over a parameter of one GAME, in one program and in one program for each value."
)
@click.option(
    "--values", type=click.IntRange(min=2), metavar="N", default=64, show_default=True, help="Values of the parameter in a --sweep."
)
@training_options
@click.option(
    "--everything",
    "folder",
    metavar="FOLDER",
    help="Instead: speeds, kernels, resuming and training, as JSON files in FOLDER; within --minutes.",
)
@click.option(
    "--minutes",
    type=click.FloatRange(min=0, min_open=True),
    metavar="N",
    default=9.0,
    show_default=True,
    help="Minutes that --everything may take.",
)
@click.option(
    "--substrates", is_flag=True, help="Instead: Melting Pot's substrates, all or the GAMEs named, one after the other; kept row by row."
)
@click.option("--from", "stored", metavar="PATH", help="Instead of measuring: the figures of a --json file or an --everything folder.")
@click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well.")
@click.option("--markdown", "page", metavar="FILE", help="Write the tables to a page: a new one, or one that has marks for them.")
@click.option("--plots", metavar="FOLDER", help="Draw speed over numbers of environments, as PNGs.")
@variant_option
@click.pass_context
def command(
    context: click.Context,
    /,
    games: tuple[str, ...],
    envs: tuple[int, ...] | None,
    observations: "tuple[tuple[Encoding, ...], ...]",
    agents: tuple[int | None, ...],
    devices: int,
    repeats: int,
    steps: int | None,
    sweep: str | None,
    values: int,
    folder: str | None,
    minutes: float,
    substrates: bool,
    stored: str | None,
    json_file: str | None,
    page: str | None,
    plots: str | None,
    variant: str | None,
    **training: Any,
) -> None:
    """Measures environment steps a second under random actions: the games of games/ itself, or the GAMEs named.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. The speed of a machine
    varies over time; the ratio to the yardstick, taken round by round, does not.
    """
    if stored or substrates:
        refuse_others(context, *(OF_STORED if stored else OF_SUBSTRATES))
    asked = asked_of(training)
    asked.check(stored is not None)
    divide_cpu(devices)
    from sjdsl.cli.bench_output import Outputs

    said = shlex.join(["sjdsl", "bench", *context.meta["written"]])
    outputs = Outputs(page, plots)
    keep = partial(_keep, json_file)
    if stored:
        _show_stored(Path(stored), outputs, said, asked, keep)
        return
    compile_everything_anew()
    if substrates:
        bench_substrates.measure_all(games, envs, repeats, steps, outputs, keep, said)
        return
    seen = flat(observations) or (OBSERVATIONS if folder else ("tokens",))
    raced = envs or ((1,) if asked.networks or sweep else tuple(number for number in RACED if number % devices == 0))
    _refuse_mixtures(context, games, seen, agents, raced, sweep, asked.networks, plots, folder)
    check_devices(context, devices, raced, alone=not (folder or sweep or asked.networks))
    tasks, refused = choose_tasks(games or main_games(), variant, seen, agents)
    if folder:
        measure_all(games or main_games(), tasks, envs, repeats, minutes, Path(folder), said)
        return
    if asked.networks:
        planned = plan_training(asked, tasks, envs[0] if envs else None, steps, repeats, keep)
    elif sweep:
        planned = _plan_sweep(tasks[0], sweep, values, (envs or SWEPT)[0], repeats, steps)
    else:
        planned = _plan_race(tasks, raced, repeats, steps, devices)
    _measure(planned, outputs, keep, said, tuple(refused))


def _keep(json_file: str | None, found: "Found") -> None:
    """Writes figures to the file of `--json`, if there is one."""
    from sjdsl.bench.stored import write_found

    if json_file:
        write_found(Path(json_file), found)


def _measure(planned: Planned, outputs: "Outputs", keep: Callable[["Found"], None], said: str, refused: tuple[str, ...]) -> None:
    """Measures what is planned, keeps the figures and shows them."""
    import jax

    what, measured = planned
    outputs.check(section := f"{what} {jax.default_backend()}")
    with stages("compiling") as tell:
        found = measured(tell)
    keep(found)
    outputs.show(Stored(section, found, said, refused))


def _plan_sweep(task: "Task", param: str, values: int, num_envs: int, repeats: int, steps: int | None) -> Planned:
    """Returns what is measured and its measurement. Raises ClickException for a parameter the game does not have, or too many values."""
    from sjdsl.bench import measure_sweep
    from sjdsl.bench.sweep import swept_params

    assert task.env is not None
    try:
        swept = swept_params(task.env, param, values)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    return f"sweep {task.name} {param}", lambda tell: measure_sweep(task, param, swept, num_envs, repeats, steps, tell=tell)


def _plan_race(tasks: "Sequence[Task]", num_envs: Sequence[int], repeats: int, steps: int | None, devices: int) -> Planned:
    """Returns what is measured and its measurement."""
    from sjdsl.bench import measure
    from sjdsl.bench.loop import steps_for

    def measured(tell: Callable[[str], object]) -> Any:
        return measure(tasks, num_envs, repeats, lambda number: steps or steps_for(number), tell, devices=devices)

    return speed_section(devices), measured


def _show_stored(path: Path, outputs: "Outputs", said: str, asked: Asked, keep: "Callable[[Found], None]") -> None:
    """Makes the tables of figures that were measured before."""
    kept = tuple(read_all(path, said))
    if asked.hours is not None and not any(hasattr(figures.found, "splits") for figures in kept):
        raise click.ClickException(f"{path} holds no figures of training, from which --hours could be extrapolated")
    outputs.check(*(figures.section for figures in kept))
    for figures in kept:
        found = with_hours(figures.found, asked.hours)
        outputs.show(figures._replace(found=found))
        if not path.is_dir():
            keep(found)


def compile_everything_anew() -> None:
    """Has JAX keep and find no programs: seconds of compiling are measured, too."""
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    jax.config.update("jax_enable_compilation_cache", False)
    compilation_cache.reset_cache()  # JAX decides at the first program of a process, which may be made by an import


def _refuse_mixtures(
    context: click.Context,
    games: tuple[str, ...],
    seen: tuple[str, ...],
    agents: tuple[int | None, ...],
    numbers: tuple[int, ...],
    sweep: str | None,
    networks: tuple[Any, ...],
    plots: str | None,
    folder: str | None,
) -> None:
    """Raises UsageError for options that are not measured together."""
    if folder and (sweep or networks or plots or len(agents) > 1):
        raise click.UsageError(
            "--everything has its own training and goes with no --sweep, --training, --plots or several --agents", context
        )
    if sweep and (len(games) != 1 or max(len(seen), len(agents), len(numbers)) > 1 or plots):
        raise click.UsageError("a sweep is of one game, one observation, one number of agents and of environments, without plots", context)
    if networks and sweep:
        raise click.UsageError("--sweep and --training are measured one at a time", context)
    if networks and (seen != ("tokens",) or len(numbers) > 1 or plots):
        raise click.UsageError("training is measured with tokens, at one number of environments, without plots", context)
