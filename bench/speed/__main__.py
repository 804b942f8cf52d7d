"""Measures what docs/performance.md shows and writes its tables; `python -m bench.speed COMMAND --help` says more of each.

python -m bench.speed race coins pd_arena --envs 1,1024 --agents own,20 --observation tokens,onehot
python -m bench.speed training coins --networks mlp,cnn --algorithms ippo,vdn --sharings shared,per_agent --hours 1e9
python -m bench.speed sweep pd_arena payoff --values 64     # many values in one program, and in a program each
python -m bench.speed substrates daycare coins              # of Melting Pot; all, unless some are named
python -m bench.speed everything runs/gpu coins       # what a GPU is needed for: speeds, kernels, resuming, training
python -m bench.speed tables runs/gpu/*.json            # from the figures of --json files or of `everything`
"""

import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import jax

from bench.speed.everything import measure_everything, parts_of
from bench.speed.outputs import Outputs, section_of, speed_section, training_section
from bench.speed.stored import Found, joined, read_found
from bench.speed.substrates import Substrates, measure_substrates, short_steps, substrate_tasks
from bench.speed.sweep import measure_sweep, swept_params
from bench.speed.training import measure_training, training_setups
from sjdsl.bench import measure
from sjdsl.bench.loop import steps_for
from sjdsl.cli.bench import AGENTS, COUNTS, OBSERVATIONS, check_devices, choose_tasks, disable_compilation_cache, divide_cpu, words
from sjdsl.cli.stages import stages
from sjdsl.library.games_folder import main_games
from sjdsl.library.substrates import written_substrates

LEAST = click.IntRange(min=1)
Command = Callable[..., Any]


def options(command: Command) -> Command:
    """Adds --repeats, and --json and --markdown, which arrive together as `outputs`."""

    def gathered(json_file: str | None, page: str | None, **others: Any) -> Any:
        return command(outputs=Outputs(json_file, page), **others)

    gathered.__name__, gathered.__doc__ = command.__name__, command.__doc__
    gathered.__click_params__ = getattr(command, "__click_params__", [])  # type: ignore[attr-defined]
    for option in (
        click.option("--repeats", type=LEAST, default=5, show_default=True, help="Rounds of timings."),
        click.option("--markdown", "page", metavar="FILE", help="Write the tables to a page that has marks for them."),
        click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well."),
    ):
        gathered = option(gathered)
    return gathered


def measured(outputs: Outputs, section: str, measurement: Callable[[Callable[[str], object]], Found], notes: Sequence[str] = ()) -> None:
    """Measures, keeps the figures and shows them; a page is looked at before anything is measured, not an hour later."""
    section = f"{section} {jax.default_backend()}"
    outputs.check(section)
    with stages("compiling") as tell:
        found = measurement(tell)
    outputs.keep(found)
    outputs.show(section, found, said(), notes)


def said() -> str:
    """Returns the command as it was called."""
    return shlex.join(["python", "-m", "bench.speed", *sys.argv[1:]])


@click.group()
def main() -> None:
    """Measures what docs/performance.md shows, and writes its tables."""
    disable_compilation_cache()


@main.command()
@click.argument("games", nargs=-1)
@click.option("--envs", type=COUNTS, default="1,128,1024,4096", show_default=True)
@click.option("--observation", "seen", type=words(OBSERVATIONS), default="tokens", show_default=True)
@click.option("--agents", type=AGENTS, default="own", show_default=True)
@click.option("--devices", type=LEAST, default=1, show_default=True)
@click.option("--steps", type=LEAST, help="Steps of one timing.")
@options
def race(games: Sequence[str], envs: Any, seen: Any, agents: Any, devices: int, steps: int | None, repeats: int, outputs: Outputs) -> None:
    """Measures environment steps a second under random actions, as `sjdsl bench` does."""
    divide_cpu(devices)
    check_devices(click.get_current_context(), devices, envs)
    tasks, refused = choose_tasks(games or main_games(), None, seen, agents)

    def timed(tell: Callable[[str], object]) -> Found:
        return measure(tasks, envs, repeats, lambda number: steps or steps_for(number), tell, devices=devices)

    measured(outputs, speed_section(devices), timed, refused)


@main.command()
@click.argument("games", nargs=-1)
@click.option("--networks", type=words(("mlp", "cnn")), default="mlp", show_default=True)
@click.option("--algorithms", type=words(("ippo", "mappo", "vdn")), default="ippo", show_default=True)
@click.option("--sharings", type=words(("shared", "per_agent", "by_role")), default="shared", show_default=True)
@click.option("--envs", type=LEAST, help="Environments: 16, of vdn 32.")
@click.option("--steps", type=LEAST, help="Steps of a rollout: 128, of vdn 1.")
@click.option("--hours", type=float, help="Also extrapolate the hours to this many environment steps, such as 1e9.")
@options
def training(
    games: Sequence[str],
    networks: Any,
    algorithms: Any,
    sharings: Any,
    envs: int | None,
    steps: int | None,
    hours: float | None,
    repeats: int,
    outputs: Outputs,
) -> None:
    """Measures updates of training, and what part of them environments, networks and learning take."""
    tasks, _ = choose_tasks(games or main_games(), None, ("tokens",), (None,))
    named = [(task.name, task.env) for task in tasks if task.env is not None]
    setups, refused = training_setups(named, networks, algorithms, sharings, envs, steps)
    if not setups:
        raise click.ClickException("; ".join(refused))
    section = training_section([(setup.network, *setup.learning) for setup in setups])
    until = None if hours is None else int(hours)
    measured(outputs, section, lambda tell: measure_training(setups, repeats, tell, until, refused, outputs.keep))


@main.command()
@click.argument("game")
@click.argument("param")
@click.option("--values", type=click.IntRange(min=2), default=64, show_default=True)
@click.option("--envs", type=LEAST, default=16, show_default=True, help="Environments of each value.")
@click.option("--steps", type=LEAST, help="Steps of one timing.")
@options
def sweep(game: str, param: str, values: int, envs: int, steps: int | None, repeats: int, outputs: Outputs) -> None:
    """Measures a sweep over PARAM of GAME, in one program and in a program for each value."""
    ((task, *_), _) = choose_tasks([game], None, ("tokens",), (None,))
    assert task.env is not None
    try:
        swept = swept_params(task.env, param, values)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    measured(outputs, f"sweep {task.name} {param}", lambda tell: measure_sweep(task, param, swept, envs, repeats, steps, tell=tell))


@main.command()
@click.argument("names", nargs=-1)
@click.option("--envs", type=COUNTS, default="1,128,1024", show_default=True)
@options
def substrates(names: Sequence[str], envs: Any, repeats: int, outputs: Outputs) -> None:
    """Measures Melting Pot's substrates one after the other; page and file are written after each of them."""
    known = {entry.name: entry for entry in written_substrates()}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise click.ClickException(f"Melting Pot has no substrate {', '.join(unknown)}; it has {', '.join(known)}")
    entries = [known[name] for name in names or known]

    def store(found: Substrates) -> None:
        outputs.keep(found)
        left = len(entries) - len(found.compilations)
        notes = (f"the run was stopped before the last {left} of {len(entries)} substrates",) if left else ()
        outputs.write(section_of(found), found, said(), notes)

    tasks = substrate_tasks(entries)
    measured(outputs, "substrates", lambda tell: measure_substrates(tasks, envs, repeats, store, short_steps, tell))


@main.command()
@click.argument("folder")
@click.argument("games", nargs=-1)
def everything(folder: str, games: Sequence[str]) -> None:
    """Measures what a GPU is needed for, most important first, each part as a JSON file in FOLDER, a new one."""
    if Path(folder).exists():
        raise click.ClickException(f"{folder} is there already; name a new folder, so that no earlier figures are mixed in")
    names = games or main_games()
    tasks, _ = choose_tasks(names, None, OBSERVATIONS, (None,))
    parts = tuple(parts_of(tasks, names[0]))
    failed = measure_everything(parts, Path(folder), click.echo)
    if failed:
        raise click.ClickException(f"{len(failed)} of {len(parts)} parts failed:\n" + "\n".join(failed))
    click.echo(f"{len(parts)} parts measured; tables: python -m bench.speed tables {folder}/*.json")


@main.command()
@click.argument("files", nargs=-1, required=True)
@click.option("--markdown", "page", metavar="FILE")
def tables(files: Sequence[str], page: str | None) -> None:
    """Makes the tables of figures that were measured before: files of --json, or those that `everything` left."""
    outputs, kept = Outputs(None, page), dict[str, Found]()
    try:
        for file in files:
            found = read_found(Path(file))
            section = section_of(found)
            kept[section] = joined(kept[section], found) if section in kept else found
    except (OSError, ValueError) as error:
        raise click.ClickException(str(error)) from None
    outputs.check(*kept)
    for section, found in kept.items():
        outputs.show(section, found, said())


if __name__ == "__main__":
    main()
