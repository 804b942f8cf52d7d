"""Measures what docs/performance.md shows; `python -m bench.speed COMMAND --help` says more of each.

python -m bench.speed race coins pd_arena --envs 1,1024 --crowd --observation tokens,onehot --json runs/race.json
python -m bench.speed training coins --networks mlp,cnn --algorithms ippo,vdn --sharings shared,per_agent --hours 1e9
python -m bench.speed sweep pd_arena payoff --values 64     # many values in one program, and in a program each
python -m bench.speed substrates daycare coins              # of Melting Pot; all, unless some are named
python -m bench.speed everything runs/gpu coins       # what a GPU is needed for: speeds, kernels, resuming, training
python -m bench.speed tables runs/*.json --markdown docs/performance.md    # of the figures that --json or `everything` left
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
from bench.speed.stored import Found, joined, read_found
from bench.speed.substrates import measure_substrates, substrate_tasks
from bench.speed.sweep import measure_sweep, swept_params
from bench.speed.tables import notes_of, section_of, tables_of
from bench.speed.training import measure_training, training_setups
from sjdsl.bench import Task, game_task, measure
from sjdsl.bench.loop import steps_for
from sjdsl.bench.machine import machine_line
from sjdsl.bench.markdown import markdown_section, replace_section
from sjdsl.bench.stored import write_found
from sjdsl.cli.bench import COUNTS, LEAST, Listed, disable_compilation_cache, print_tables
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
    "--repeats", type=LEAST, default=5, show_default=True, help="Rounds of timings."
)
json_option = click.option(
    "--json", "file", type=click.Path(path_type=Path), help="Write the figures to a file as well."
)


def words(*known: str) -> Listed:
    return Listed(click.Choice(known))


def measured(file: Path | None, measurement: Callable[[Callable[[str], object]], Found]) -> None:
    """Measures, stores and shows figures, with the command as it was called."""
    with stages("compiling") as tell:
        found = measurement(tell)
    found.machine["command"] = called()
    if file:
        write_found(file, found)
    print_tables(tables_of(found), found.machine, notes_of(found))


def called() -> str:
    return shlex.join(["python", "-m", "bench.speed", *sys.argv[1:]])


def task_of(game: str, observation: Encoding = "tokens") -> Task:
    try:
        return game_task(make(game, observation=observation))
    except (CompileError, ValueError, FileNotFoundError) as error:
        raise click.ClickException(str(error)) from None


def crowd_of(game: str, observation: Encoding) -> Task:
    """Returns a game with many agents, or its variant `crowd` if it has too little room for them. Raises CompileError."""
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
    """Returns what is measured of games, also with many agents if wanted, and a line for each game that refuses so many."""
    tasks, refused = [], []
    for game in games:
        tasks += [task_of(game, observation) for observation in observations]
        try:
            tasks += [crowd_of(game, observation) for observation in observations if crowd]
        except CompileError as error:
            messages = "; ".join(mistake.message for mistake in error.diagnostics)
            refused.append(f"{game} can't have {CROWD} agents: {messages}")
    return tasks, refused


@click.group()
def main() -> None:
    """Measures what docs/performance.md shows, and makes its tables."""
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
    type=LEAST,
    default=1,
    show_default=True,
    help="Split the environments over devices; JAX_NUM_CPU_DEVICES divides a CPU.",
)
@click.option("--steps", type=LEAST, help="Steps of one timing.")
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

    def timed(tell: Callable[[str], object]) -> Found:
        found = measure(
            tasks, envs, repeats, lambda number: steps or steps_for(number), tell, devices=devices
        )
        return replace(found, left_out=tuple(refused))

    measured(file, timed)


@main.command()
@click.argument("games", nargs=-1)
@click.option("--networks", type=words("mlp", "cnn"), default="mlp", show_default=True)
@click.option("--algorithms", type=words("ippo", "mappo", "vdn"), default="ippo", show_default=True)
@click.option("--sharings", type=words("shared", "per_agent"), default="shared", show_default=True)
@click.option("--envs", type=LEAST, help="Environments: 16, of vdn 32.")
@click.option("--steps", type=LEAST, help="Steps of a rollout: 128, of vdn 1.")
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
    """Measures updates of training, and what part of them environments, networks and learning take."""
    named = [
        (env.name, env) for game in games or main_games() if (env := task_of(game).env) is not None
    ]
    setups, refused = training_setups(named, networks, algorithms, sharings, envs, steps)
    if not setups:
        raise click.ClickException("; ".join(refused))
    until = None if hours is None else int(hours)
    keep = partial(write_found, file) if file else lambda _: None
    measured(file, lambda tell: measure_training(setups, repeats, tell, until, refused, keep))


@main.command()
@click.argument("game")
@click.argument("param")
@click.option("--values", type=click.IntRange(min=2), default=64, show_default=True)
@click.option(
    "--envs", type=LEAST, default=16, show_default=True, help="Environments of each value."
)
@click.option("--steps", type=LEAST, help="Steps of one timing.")
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
        swept = swept_params(task.env, param, values)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    measured(file, lambda tell: measure_sweep(task, param, swept, envs, repeats, steps, tell=tell))


@main.command()
@click.argument("names", nargs=-1)
@click.option("--envs", type=COUNTS, default="1,128,1024", show_default=True)
@repeats_option
@json_option
def substrates(names: Sequence[str], envs: Any, repeats: int, file: Path | None) -> None:
    """Measures Melting Pot's substrates one after the other; the file is written after each of them."""
    known = {entry.name: entry for entry in written_substrates()}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise click.ClickException(
            f"Melting Pot has no substrate {', '.join(unknown)}; it has {', '.join(known)}"
        )
    tasks = substrate_tasks(known[name] for name in names or known)
    keep = partial(write_found, file) if file else lambda _: None
    measured(file, lambda tell: measure_substrates(tasks, envs, repeats, keep, tell=tell))


@main.command()
@click.argument("folder")
@click.argument("games", nargs=-1)
def everything(folder: str, games: Sequence[str]) -> None:
    """Measures what a GPU is needed for, most important first, each part as a JSON file in FOLDER, a new one."""
    if Path(folder).exists():
        raise click.ClickException(
            f"{folder} is there already; name a new folder, so that no earlier figures are mixed in"
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
    """Makes the tables of figures that were measured before: files of --json, or those that `everything` left."""
    kept: dict[str, Found] = {}
    text = page.read_text(encoding="utf-8") if page else ""
    try:
        for file in files:
            found = read_found(Path(file))
            section = section_of(found)
            kept[section] = joined(kept[section], found) if section in kept else found
        for section, found in kept.items():
            made, notes = tables_of(found), notes_of(found)
            print_tables(made, found.machine, notes)
            if page:
                command = found.machine.get("command", called())
                text = replace_section(
                    text,
                    section,
                    markdown_section(command, machine_line(found.machine), notes, made),
                )
    except (OSError, ValueError) as error:
        raise click.ClickException(str(error)) from None
    if page:
        write_whole(page, text)


if __name__ == "__main__":
    main()
