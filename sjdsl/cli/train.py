"""`sjdsl train`: trains agents in a game, and compares them with random ones."""

import json
import shlex
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import (
    EnvironmentOptions,
    environment_options,
    make_environment,
    named_in,
    written_options,
)
from sjdsl.cli.evaluate import evaluate_run, list_files
from sjdsl.cli.provenance import located
from sjdsl.cli.run_options import RunOptions, check_policies, run_options
from sjdsl.cli.stages import LOADING, stages
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.extras import MissingExtra, is_installed
from sjdsl.trainers import Preset, load_preset, make_config
from sjdsl.trainers.runs.manifest import read_manifest
from sjdsl.trainers.runs.run_lock import is_unused
from sjdsl.trainers.runs.seeds_in_words import seeds_in_words, seeds_of_each
from sjdsl.trainers.runs.stages import stage_folders
from sjdsl.trainers.settings.config import stored_config
from sjdsl.trainers.settings.extensions import find, lasting, require_allowed, short_name
from sjdsl.trainers.settings.own_settings import OWN, taken_settings

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment
    from sjdsl.trainers import Config, Result
    from sjdsl.trainers.runs.loggers import LoggerName

EPISODES = 30  # of the evaluation at the end
BESIDE_RESUME = (
    "resumed",
    "game",
    "map_file",
    "episodes",
    "loggers",
    "callback",
    "distributed",
    "keys",
    "allow_code",
)


@click.command("train")
@click.argument("game", required=False)
@run_options()
@click.option(
    "--run", "run_dir", metavar="DIR", help="Folder of the run; by default a new one in runs/."
)
@click.option(
    "--resume",
    "resumed",
    metavar="DIR",
    help="Continue a stopped run; --set total_timesteps=… extends it, GAME says where its game is now.",
)
@click.option(
    "--episodes",
    type=click.IntRange(min=0),
    metavar="N",
    help=f"Episodes of evaluation.  [default: {EPISODES}]",
)
@click.option(
    "--callback", metavar="FILE.py:NAME", help="Call your own function after each update."
)
@click.option(
    "--distributed", is_flag=True, help="Run as one of several processes: docs/training.md."
)
@click.option("--keys", is_flag=True, help="List all settings with their values, and stop.")
@environment_options
def command(
    game: str | None,
    run: RunOptions,
    run_dir: str | None,
    resumed: str | None,
    episodes: int | None,
    callback: str | None,
    distributed: bool,
    keys: bool,
    options: EnvironmentOptions,
) -> None:
    """Trains agents in GAME, a bundled game or a `.sj` file, and evaluates them.

    The run's folder gets a manifest, metrics, checkpoints, policies, a learning curve and the evaluation: docs/training.md.
    """
    if distributed:
        join_processes()
    if resumed is not None:
        only_longer = [*run.changes] == ["total_timesteps"]
        wrong = written_options(*BESIDE_RESUME, *(["changes"] if only_longer else []))
        if wrong:
            raise click.UsageError(
                f"a resumed run keeps its settings, except total_timesteps: leave out {', '.join(wrong)}"
            )
        _resume(
            Path(resumed),
            game,
            options.map,
            episodes,
            run.loggers or None,
            callback,
            run.changes.get("total_timesteps"),
        )
        return
    preset = _choose(game, run, needed=not keys)
    if keys:
        _list_keys(preset.config)
        return
    game, config, parts = preset.game or "", preset.config, [*preset.earlier, preset]
    preset.refuse_of_stages(options.names)
    chosen = [options.or_else(part.environment) for part in parts]
    for number, (part, one) in enumerate(zip(parts, chosen, strict=True), 1):
        try:
            check_policies(part.config, one.check(game))
        except (CompileError, click.ClickException):
            if preset.earlier:
                click.echo(f"{preset.place}[{number}]:", err=True)
            raise
    if (
        run_dir and not distributed and not is_unused(Path(run_dir))
    ):  # of several processes, another may have begun to write there
        raise click.ClickException(
            f"{run_dir} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it: "
            f"sjdsl train --resume {shlex.quote(run_dir)}"
        )
    episodes = EPISODES if episodes is None else episodes
    for number, part in enumerate(parts, 1):
        click.echo(f"stage {number}: " * (len(parts) > 1) + extent_of(part.config), err=True)
    with stages(LOADING):
        from sjdsl.trainers import Stage, check_stages, train
        from sjdsl.trainers.runs.loggers import check_loggers

        check_loggers(run.loggers)
        provenances = [one.describe(game) for one in chosen]
        environments = [make_environment(described) for described in provenances]
        configs = [part.config for part in parts]
        *earlier, last = map(Stage, environments, configs, provenances)
        check_stages([*earlier, last], preset.place)
        found, asked = find_callback(callback)
    env = environments[-1]
    kind = (
        f"{env.name}_{short_name(config.algorithm)}_{short_name(config.reward)}_seed{config.seed}"
    )
    path = Path(run_dir) if run_dir else new_folder(kind)
    asked_for = {"episodes": episodes, **asked}
    result = train(
        env, config, path, "auto", last.provenance, run.loggers, asked_for, found, earlier
    )
    _finish(result, env, config, episodes)


def _list_keys(config: "Config") -> None:
    """Prints the settings of a configuration with their values; of those that nothing reads, also when they would be read."""
    for name, value in config.model_dump(mode="json", exclude={"own"}).items():
        mark = config.unread.get(name)
        click.echo(
            f"{name} = {json.dumps(value)}"
            + (f"  # read where {mark.setting} is {mark.values}" if mark else "")
        )
    given = dict(config.own)
    for name, default, hook in taken_settings(config.hooks):
        click.echo(
            f"{OWN}{name} = {json.dumps(given.get(name, default), default=str)}  # of {hook}"
        )


def extent_of(config: "Config") -> str:
    """Returns how much the run trains: whole updates, which may be more than `total_timesteps`."""
    steps, updates = config.num_updates * config.steps_per_update, config.num_updates
    plan = f"{updates:,} update{'s' * (updates != 1)} of {config.num_envs} environments x {config.num_steps} steps"
    what = f"{steps:,} environment steps{' of each seed' if config.seeds > 1 else ''}"
    if steps == config.total_timesteps:
        return f"training {what}: {plan}"
    return f"training {what} (total_timesteps={config.total_timesteps:,} is rounded up to whole updates): {plan}"


def _resume(
    path: Path,
    game: str | None,
    map_file: str | None,
    episodes: int | None,
    loggers: "tuple[LoggerName, ...] | None",
    callback: str | None,
    longer: str | None,
) -> None:
    """Continues a run. `game`, `map_file`: where its game and map are now."""
    manifest = read_manifest(path)
    from sjdsl.trainers import resume
    from sjdsl.trainers.runs.loggers import check_loggers

    check_loggers(manifest.get("loggers", ()) if loggers is None else loggers)
    if episodes is None:
        episodes = manifest.get("asked", {}).get("episodes", EPISODES)
    if "game" not in manifest.get("provenance", {}):
        raise click.ClickException(
            f"the manifest of {path} doesn't say which game was trained; resume the run from Python: sjdsl.trainers.resume(env, {str(path)!r})"
        )
    if longer is None and manifest.get("status") == "finished":
        click.echo(
            f"the run in {path} is finished, so it is only evaluated again; "
            f"sjdsl train --resume {shlex.quote(str(path))} --set total_timesteps=… makes it longer",
            err=True,
        )
    kept = manifest.get("asked", {}).get("callback")
    if callback is None and kept is not None:
        require_allowed("callback", kept, str(path / "manifest.json"))
    command = f"sjdsl train GAME --resume {shlex.quote(str(path))}"
    provenance = located(
        manifest["provenance"], manifest["game"].get("hash", ""), path, command, game, map_file
    )
    earlier = [
        located(known["provenance"], known["game"].get("hash", ""), folder, command, game)
        for folder in stage_folders(path)[:-1]
        for known in [read_manifest(folder)]
    ]
    with stages(LOADING), named_in(path / "manifest.json"):
        env = make_environment(provenance)
        environments = [make_environment(made) for made in earlier]
    found, asked = find_callback(callback or kept)
    total = None if longer is None else make_config(total_timesteps=longer).total_timesteps
    result = resume(
        env,
        path,
        loggers=loggers,
        asked={"episodes": episodes, **asked},
        callback=found,
        total_timesteps=total,
        provenance=provenance,
        earlier=environments,
    )
    _finish(result, env, stored_config(read_manifest(path)["config"]), episodes)


def find_callback(name: str | None) -> tuple[Any, dict[str, str]]:
    """Returns the callback of a name, and the name for the manifest."""
    return (
        (None, {})
        if name is None
        else (find("callback", name), {"callback": lasting("callback", name)})
    )


def _finish(result: "Result", env: "Environment", config: "Config", episodes: int) -> None:
    """Evaluates each seed's policy, and prints the time and memory of the run."""
    import jax

    from sjdsl.trainers.runs.learning_curve import LEARNING_CURVE
    from sjdsl.trainers.runs.metrics_files import METRICS_JSONL, read_rows
    from sjdsl.trainers.runs.progress import rate

    if jax.process_index() != 0:
        return
    if result.stage:
        path = shlex.quote(str(result.run_dir.parents[1]))
        click.echo(
            f"\nthe callback ended the run in stage {result.stage}; sjdsl train --resume {path} continues it"
        )
        return
    for folder, seed in zip(result.folders, config.seed_numbers, strict=True):
        if episodes:
            evaluate_run(folder, env, episodes, seed)
    went_on = next(
        folder
        for folder, seed in zip(result.folders, config.seed_numbers, strict=True)
        if seed not in result.diverged
    )
    (last,) = deque(read_rows(went_on / METRICS_JSONL), maxlen=1)
    steps = result.updates * config.steps_per_update * config.seeds
    steps_before = last["env_steps"] - result.updates * config.steps_per_update
    speed = rate(last, config.seeds, steps_before)
    whose = "the last stage: " if "stage" in last else ""
    click.echo(
        f"\n{whose}{steps:,} environment steps in {last['seconds']:,.1f} s: {speed:,.0f} steps a second; "
        f"compiling took {result.compile_seconds:.1f} s; at most {result.peak_megabytes:,.0f} MB of memory"
    )
    if not is_installed("matplotlib"):
        click.echo(f"no learning curve was drawn: {MissingExtra('matplotlib', 'plots')}")
    elif not any((folder / LEARNING_CURVE).exists() for folder in result.folders):
        click.echo(
            f"no learning curve was drawn, as no episode ended within the {config.num_steps * result.updates:,} steps of each environment"
        )
    for update, seeds in seeds_of_each(result.diverged.items()).items():
        click.echo(
            f"{seeds_in_words(seeds)} diverged (non-finite loss) in update {update}; the policy of update {update - 1} is kept"
        )
    list_files(result.run_dir)


def join_processes() -> None:
    """Joins the other processes, by the environment variables of a cluster or JAX's own."""
    import os

    import jax

    given = {
        "coordinator_address": "JAX_COORDINATOR_ADDRESS",
        "num_processes": "JAX_NUM_PROCESSES",
        "process_id": "JAX_PROCESS_ID",
    }
    found = {
        name: os.environ[variable] for name, variable in given.items() if variable in os.environ
    }
    numbers: dict[str, Any] = {
        name: value if name == "coordinator_address" else int(value)
        for name, value in found.items()
    }
    try:
        jax.distributed.initialize(**numbers)
    except (ValueError, RuntimeError) as error:
        wanted = ", ".join(given.values())
        raise click.ClickException(
            f"can't join the other processes: {error}; outside a cluster, set {wanted}"
        ) from None


def _choose(game: str | None, run: RunOptions, needed: bool) -> Preset:
    """Returns the preset with the changes of the command line; without a preset, the game and the configuration as one."""
    if run.preset is None:
        if game is None and needed:
            raise click.UsageError(
                "name the game to train in, as in `sjdsl train clean_up`, or a preset that names one"
            )
        return Preset(game, {}, make_config(run.settings))
    loaded = load_preset(run.preset, run.settings, game)
    if loaded.game is None and needed:
        raise click.UsageError(
            f"the preset `{run.preset}` doesn't name a game: name one, as in `sjdsl train clean_up --preset {run.preset}`"
        )
    for name in loaded.left_out:
        mark = loaded.config.unread.get(name)
        setting = mark.setting if mark else "algorithm"
        where = (
            ": no hook takes it"
            if name.startswith(OWN)
            else f" while `{setting}` is {getattr(loaded.config, setting)}"
        )
        click.echo(f"the preset's `{name}` has no effect{where}", err=True)
    return loaded


def new_folder(name: str) -> Path:
    """Returns a new folder in `runs`: `name`, or `name_2`, `name_3` and so on."""
    number = 1
    while (path := Path("runs") / (name if number == 1 else f"{name}_{number}")).exists():
        number += 1
    return path
