"""Measures the figures of docs/research/speed_tables.md.

`python -m bench.speed COMMAND --help` explains each command. Examples:

    python -m bench.speed race coins pd_arena --envs 1,1024 --crowd --json runs/race.json
    python -m bench.speed training coins --networks mlp,cnn --algorithms ippo,vdn --hours 1e9
    python -m bench.speed sweep pd_arena payoff --values 64  # many values in one program
    python -m bench.speed substrates daycare coins  # of Melting Pot; all, unless some are named
    python -m bench.speed everything runs/gpu coins  # what a GPU is needed for
    python -m bench.speed tables runs/*.json --markdown docs/research/speed_tables.md
"""

import shlex
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click

from bench.speed.everything import measure_everything, parts_of
from bench.speed.stored import Figures, joined, read_figures
from bench.speed.substrates import measure_substrates, substrate_tasks
from bench.speed.sweep import measure_sweep, swept_params
from bench.speed.tables import notes_of, section_of, tables_of
from bench.speed.training import measure_training, training_setups
from sjdsl.bench import Task, game_task, measure
from sjdsl.bench.loop import steps_for
from sjdsl.bench.machine import machine_line
from sjdsl.bench.markdown import markdown_section, replace_section
from sjdsl.bench.stored import write_figures
from sjdsl.cli.bench import COUNTS, POSITIVE, Listed, disable_compilation_cache, print_tables
from sjdsl.cli.stages import stages
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.files import write_whole
from sjdsl.library.factory import make
from sjdsl.library.games_folder import main_games
from sjdsl.library.substrates import written_substrates
from sjdsl.runtime.env import Encoding

CROWD = 20  # agents
OBSERVATIONS: tuple[Encoding, ...] = ("tokens", "onehot")
repeats_option = click.option(
    "--repeats", type=POSITIVE, default=5, show_default=True, help="Rounds of timings."
)
json_option = click.option(
    "--json", "file", type=click.Path(path_type=Path), help="Write the figures to a file as well."
)


def words(*known: str) -> Listed:
    """Returns the type of an option: some of these words, separated by commas."""
    return Listed(click.Choice(known))


def report(file: Path | None, measurement: Callable[[Callable[[str], object]], Figures]) -> None:
    """Measures, stores and prints figures, with the command line."""
    with stages("compiling") as tell:
        figures = measurement(tell)
    figures.machine["command"] = command_line()
    if file:
        write_figures(file, figures)
    print_tables(tables_of(figures), figures.machine, notes_of(figures))


def command_line() -> str:
    return shlex.join(["python", "-m", "bench.speed", *sys.argv[1:]])


def task_of(game: str, observation: Encoding = "tokens") -> Task:
    """Returns the task of a game. Raises ClickException if it can't be made."""
    try:
        return game_task(make(game, observation=observation))
    except (CompileError, ValueError, FileNotFoundError) as error:
        raise click.ClickException(str(error)) from None


def crowd_of(game: str, observation: Encoding) -> Task:
    """Returns a game with many agents, or its variant `crowd` if it has too little room for them.

    Raises CompileError.
    """
    try:
        env = make(game, num_agents=CROWD, observation=observation)
        return game_task(env, crowd=CROWD)
    except CompileError as refusal:
        try:
            env = make(game, "crowd", CROWD, observation=observation)
        except CompileError:
            raise refusal from None
        return game_task(env, f"{env.name}+crowd", CROWD)


def forms_of(
    games: Sequence[str], observations: Sequence[Encoding], crowd: bool
) -> tuple[list[Task], list[str]]:
    """Returns the tasks of games, with `crowd` also those with many agents, and a line for each
    game that can't have so many."""
    tasks = []
    refused = []
    for game in games:
        tasks += [task_of(game, observation) for observation in observations]
        if crowd:
            try:
                tasks += [crowd_of(game, observation) for observation in observations]
            except CompileError as error:
                messages = "; ".join(diagnostic.message for diagnostic in error.diagnostics)
                refused.append(f"{game} can't have {CROWD} agents: {messages}")
    return tasks, refused


@click.group()
def main() -> None:
    """Measures the figures of docs/research/speed_tables.md, and makes its tables."""
    disable_compilation_cache()


@main.command()
@click.argument("games", nargs=-1)
@click.option("--envs", type=COUNTS, default="1,128,1024,4096", show_default=True)
@click.option(
    "--observation", "observations", type=words(*OBSERVATIONS), default="tokens", show_default=True
)
@click.option(
    "--crowd", is_flag=True, help=f"Also with {CROWD} agents, in games that can have so many."
)
@click.option(
    "--devices",
    type=POSITIVE,
    default=1,
    show_default=True,
    help="Split the environments over devices; JAX_NUM_CPU_DEVICES divides a CPU.",
)
@click.option("--steps", type=POSITIVE, help="Steps of one timing.")
@repeats_option
@json_option
def race(
    games: Sequence[str],
    envs: Any,
    observations: Any,
    crowd: bool,
    devices: int,
    steps: int | None,
    repeats: int,
    file: Path | None,
) -> None:
    """Measures environment steps a second under random actions, as `sjdsl bench` does."""
    tasks, refused = forms_of(games or main_games(), observations, crowd)

    def measurement(tell: Callable[[str], object]) -> Figures:
        figures = measure(
            tasks, envs, repeats, lambda number: steps or steps_for(number), tell, devices=devices
        )
        return replace(figures, left_out=tuple(refused))

    report(file, measurement)


@main.command()
@click.argument("games", nargs=-1)
@click.option("--networks", type=words("mlp", "cnn"), default="mlp", show_default=True)
@click.option("--algorithms", type=words("ippo", "mappo", "vdn"), default="ippo", show_default=True)
@click.option("--sharings", type=words("shared", "per_agent"), default="shared", show_default=True)
@click.option("--envs", type=POSITIVE, help="Environments: 16, of vdn 32.")
@click.option("--steps", type=POSITIVE, help="Steps of a rollout: 128, of vdn 1.")
@click.option(
    "--hours",
    type=float,
    help="Also extrapolate the hours to this many environment steps, such as 1e9.",
)
@repeats_option
@json_option
def training(
    games: Sequence[str],
    networks: Any,
    algorithms: Any,
    sharings: Any,
    envs: int | None,
    steps: int | None,
    hours: float | None,
    repeats: int,
    file: Path | None,
) -> None:
    """Measures updates of training, and what part of them environments, networks and learning
    take.
    """
    environments = [task_of(game).env for game in games or main_games()]
    named = [(env.name, env) for env in environments if env is not None]
    setups, refused = training_setups(named, networks, algorithms, sharings, envs, steps)
    if not setups:
        raise click.ClickException("; ".join(refused))
    hours_to = None if hours is None else int(hours)
    keep = partial(write_figures, file) if file else lambda _: None
    report(file, lambda tell: measure_training(setups, repeats, tell, hours_to, refused, keep))


@main.command()
@click.argument("game")
@click.argument("param")
@click.option("--values", type=click.IntRange(min=2), default=64, show_default=True)
@click.option(
    "--envs", type=POSITIVE, default=16, show_default=True, help="Environments of each value."
)
@click.option("--steps", type=POSITIVE, help="Steps of one timing.")
@repeats_option
@json_option
def sweep(
    game: str,
    param: str,
    values: int,
    envs: int,
    steps: int | None,
    repeats: int,
    file: Path | None,
) -> None:
    """Measures a sweep over PARAM of GAME, in one program and in a program for each value."""
    task = task_of(game)
    assert task.env is not None
    try:
        params = swept_params(task.env, param, values)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    report(file, lambda tell: measure_sweep(task, param, params, envs, repeats, steps, tell=tell))


@main.command()
@click.argument("names", nargs=-1)
@click.option("--envs", type=COUNTS, default="1,128,1024", show_default=True)
@repeats_option
@json_option
def substrates(names: Sequence[str], envs: Any, repeats: int, file: Path | None) -> None:
    """Measures Melting Pot's substrates one after the other; the file is written after each of
    them.
    """
    known = {entry.name: entry for entry in written_substrates()}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise click.ClickException(
            f"Melting Pot has no substrate {', '.join(unknown)}; it has {', '.join(known)}"
        )
    tasks = substrate_tasks(known[name] for name in names or known)
    keep = partial(write_figures, file) if file else lambda _: None
    report(file, lambda tell: measure_substrates(tasks, envs, repeats, keep, tell=tell))


@main.command()
@click.argument("folder")
@click.argument("games", nargs=-1)
def everything(folder: str, games: Sequence[str]) -> None:
    """Measures all figures that need a GPU, most important first, each part as a JSON file in
    FOLDER, a new one."""
    if Path(folder).exists():
        raise click.ClickException(
            f"{folder} exists already; name a new folder, so that no earlier figures are mixed in"
        )
    names = games or main_games()
    tasks = [task_of(name, observation) for name in names for observation in OBSERVATIONS]
    parts = tuple(parts_of(tasks, names[0]))
    failed = measure_everything(parts, Path(folder), click.echo)
    if failed:
        raise click.ClickException(
            f"{len(failed)} of {len(parts)} parts failed:\n" + "\n".join(failed)
        )
    click.echo(f"{len(parts)} parts measured; tables: python -m bench.speed tables {folder}/*.json")


@main.command()
@click.argument("files", nargs=-1, required=True)
@click.option(
    "--markdown",
    "page",
    type=click.Path(exists=True, path_type=Path),
    help="Also write them to a page that has marks for them.",
)
def tables(files: Sequence[str], page: Path | None) -> None:
    """Makes the tables of figures that were measured before: files of --json, or those of
    `everything`."""
    by_section: dict[str, Figures] = {}
    text = page.read_text(encoding="utf-8") if page else ""
    try:
        for file in files:
            figures = read_figures(Path(file))
            section = section_of(figures)
            if section in by_section:
                figures = joined(by_section[section], figures)
            by_section[section] = figures
        for section, figures in by_section.items():
            section_tables = tables_of(figures)
            notes = notes_of(figures)
            print_tables(section_tables, figures.machine, notes)
            if page:
                command = figures.machine.get("command", command_line())
                machine = machine_line(figures.machine)
                markdown = markdown_section(command, machine, notes, section_tables)
                text = replace_section(text, section, markdown)
    except (OSError, ValueError) as error:
        raise click.ClickException(str(error)) from None
    if page:
        write_whole(page, text)


if __name__ == "__main__":
    main()
