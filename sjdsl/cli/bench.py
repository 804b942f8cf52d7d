"""`sjdsl bench`: measures the speed of games, beside a hand-written game in the same process."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.bench_everything import Stored, measure_all, read_all, section_of
from sjdsl.cli.bench_games import choose_tasks
from sjdsl.cli.bench_options import NETWORKS, OBSERVATIONS, Agents, Counts, Quoting, Words
from sjdsl.cli.game_file import variant_option
from sjdsl.cli.stages import stages
from sjdsl.games_folder import bundled

if TYPE_CHECKING:
    from sjdsl.bench import Task
    from sjdsl.bench.stored import Found
    from sjdsl.cli.bench_output import Outputs
    from sjdsl.runtime.env import Encoding

RACED = (1, 128, 1024, 4096)  # environments
SWEPT = (16,)  # of each value
TRAINED = (16,)
ROLLOUT = 128  # steps


@click.command("bench", cls=Quoting)
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option(
    "--envs", type=Counts(), help="Numbers of environments at once: 1,128,1024,4096; in a sweep, of each value: 16; in training: 16."
)
@click.option(
    "--observation", "observations", type=Words(OBSERVATIONS), multiple=True, help="tokens (the default), onehot or tokens,onehot."
)
@click.option("--agents", type=Agents(), default="own", show_default=True, help="Numbers of agents, such as own,20.")
@click.option("--repeats", type=click.IntRange(min=1), default=5, show_default=True, help="Rounds of timings.")
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    help="Steps of one timing; by default about 40,000 environment steps; of a rollout in training: 128.",
)
@click.option(
    "--sweep", metavar="PARAM", help="Instead: a sweep over a parameter of one GAME, in one program and in one program for each value."
)
@click.option("--values", type=click.IntRange(min=2), default=64, show_default=True, help="Number of values.")
@click.option("--training", "networks", type=Words(NETWORKS), metavar="NETWORKS", help="Instead: an update of IPPO: mlp, cnn or mlp,cnn.")
@click.option(
    "--everything",
    "folder",
    metavar="FOLDER",
    help="Instead: speeds, kernels, resuming and training, as JSON files in FOLDER; within --minutes.",
)
@click.option("--minutes", type=click.FloatRange(min=0, min_open=True), default=9.0, show_default=True, help="Time for --everything.")
@click.option("--from", "stored", metavar="PATH", help="Instead of measuring: the figures of a --json file or an --everything folder.")
@click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well.")
@click.option("--markdown", "page", metavar="FILE", help="Write the tables to a page: a new one, or between the marks of one there is.")
@click.option("--plots", metavar="FOLDER", help="Draw speed over numbers of environments, as PNGs.")
@variant_option
@click.pass_context
def command(
    context: click.Context,
    games: tuple[str, ...],
    envs: tuple[int, ...] | None,
    observations: "tuple[tuple[Encoding, ...], ...]",
    agents: tuple[int | None, ...],
    repeats: int,
    steps: int | None,
    sweep: str | None,
    values: int,
    networks: tuple[Any, ...],
    folder: str | None,
    minutes: float,
    stored: str | None,
    json_file: str | None,
    page: str | None,
    plots: str | None,
    variant: str | None,
) -> None:
    """Measures environment steps a second under random actions: all bundled games, or the GAMEs named.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. The speed of a machine
    varies over time; the ratio to the yardstick, taken round by round, does not.
    """
    import jax

    from sjdsl.bench.loop import steps_for
    from sjdsl.bench.stored import write_found
    from sjdsl.cli.bench_output import Outputs

    said = shlex.join(["sjdsl", "bench", *context.meta["written"]])
    outputs = Outputs(page, plots)
    if stored:
        _show_stored(Path(stored), outputs, said)
        return
    compile_everything_anew()
    seen = tuple(dict.fromkeys(word for words in observations for word in words)) or (OBSERVATIONS if folder else ("tokens",))
    numbers = envs or (SWEPT if sweep else TRAINED if networks else RACED)
    _refuse_mixtures(context, games, seen, agents, numbers, sweep, networks, plots, folder)
    tasks, refused = choose_tasks(games or bundled(), variant, seen, agents)
    if folder:
        measure_all(games or bundled(), tasks, envs, repeats, minutes, Path(folder), said)
        return
    from sjdsl.bench import measure, measure_sweep, measure_training

    what = f"sweep {tasks[0].name} {sweep}" if sweep else f"training {','.join(networks)}" if networks else "speed"
    outputs.check(f"{what} {jax.default_backend()}")
    found: Found
    with stages("compiling") as tell:
        if networks:
            trained = [task.env for task in tasks if task.env is not None]
            found = measure_training(trained, networks, numbers[0], steps or ROLLOUT, repeats, tell)
        elif sweep:
            found = measure_sweep(tasks[0], sweep, _swept(tasks[0], sweep, values), numbers[0], repeats, steps, tell=tell)
        else:
            found = measure(tasks, numbers, repeats, lambda n: steps or steps_for(n), tell)
    if json_file:
        write_found(Path(json_file), found)
    outputs.show(Stored(section_of(found), found, said, tuple(refused)))


def _show_stored(path: Path, outputs: "Outputs", said: str) -> None:
    """Makes the tables of figures that were measured before."""
    kept = tuple(read_all(path, said))
    outputs.check(*(figures.section for figures in kept))
    for figures in kept:
        outputs.show(figures)


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


def _swept(task: "Task", param: str, number: int) -> "list[Any]":
    """Returns the values of a sweep. Raises ClickException for a parameter the game does not have, or too many values."""
    from sjdsl.bench.sweep import swept_params

    assert task.env is not None
    try:
        return swept_params(task.env, param, number)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
