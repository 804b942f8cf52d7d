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
    without_quoting_game,
    written_options,
)
from sjdsl.cli.evaluate import evaluate_run, list_files
from sjdsl.cli.provenance import locate
from sjdsl.cli.run_options import RunOptions, check_policies, run_options
from sjdsl.cli.stages import LOADING, stages
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.extras import MissingExtra, is_installed
from sjdsl.trainers import Preset, load_preset, make_config
from sjdsl.trainers.runs.learning_curve import LEARNING_CURVE
from sjdsl.trainers.runs.loggers import check_loggers
from sjdsl.trainers.runs.manifest import read_manifest
from sjdsl.trainers.runs.metrics_files import METRICS_JSONL, read_rows
from sjdsl.trainers.runs.progress import rate
from sjdsl.trainers.runs.run_lock import is_unused
from sjdsl.trainers.runs.seeds_in_words import seeds_in_words, seeds_of_each
from sjdsl.trainers.runs.stages import stage_folders
from sjdsl.trainers.settings.config import stored_config
from sjdsl.trainers.settings.extensions import absolute_name, find, require_allowed, short_name
from sjdsl.trainers.settings.own_settings import OWN, taken_settings

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment
    from sjdsl.trainers import Config, Result
    from sjdsl.trainers.runs.loggers import LoggerName

EPISODES = 30  # of the evaluation at the end
BESIDE_RESUME = (  # parameters of the command that are allowed with --resume
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
    help="Continue a stopped run; --set total_timesteps=… extends it, GAME says where its game is "
    "now.",
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
@click.option("--distributed", is_flag=True, help="Run as one of several processes: docs/runs.md.")
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

    The run's folder gets a manifest, metrics, checkpoints, policies, a learning curve and the
    evaluation: docs/runs.md.
    """
    if distributed:
        join_processes()
    if resumed is not None:
        total_timesteps = run.changes.get("total_timesteps")
        allowed: tuple[str, ...] = BESIDE_RESUME
        if total_timesteps is not None and len(run.changes) == 1:
            allowed += ("changes",)
        if refused := written_options(*allowed):
            raise click.UsageError(
                "a resumed run keeps its settings, except total_timesteps: "
                f"leave out {', '.join(refused)}"
            )
        loggers = run.loggers or None
        _resume(Path(resumed), game, options.map, episodes, loggers, callback, total_timesteps)
        return
    preset = _choose_preset(game, run, needed=not keys)
    config = preset.config
    if keys:
        _list_keys(config)
        return
    game = preset.game or ""
    preset.refuse_of_stages(options.names)
    stage_presets = [*preset.earlier, preset]
    stage_options = [options.or_else(stage.environment) for stage in stage_presets]
    for number, stage in enumerate(stage_presets):
        try:
            check_policies(stage.config, stage_options[number].check(game))
        except (CompileError, click.ClickException):
            if preset.earlier:
                click.echo(f"{preset.place}[{number + 1}]:", err=True)
            raise
    # The other processes of a distributed run may have begun to write to its folder.
    if run_dir and not distributed and not is_unused(Path(run_dir)):
        raise click.ClickException(
            f"{run_dir} is not empty; name a new folder, so that no earlier run is lost, "
            f"or resume the run in it: sjdsl train --resume {shlex.quote(run_dir)}"
        )
    if episodes is None:
        episodes = EPISODES
    for number, stage in enumerate(stage_presets, 1):
        prefix = f"stage {number}: " if preset.earlier else ""
        click.echo(prefix + extent_of(stage.config), err=True)
    with stages(LOADING):
        from sjdsl.trainers import Stage, check_stages, train

        check_loggers(run.loggers)
        provenances = [options_of_stage.describe(game) for options_of_stage in stage_options]
        environments = [make_environment(provenance) for provenance in provenances]
        configs = [stage.config for stage in stage_presets]
        *earlier, last = map(Stage, environments, configs, provenances)
        check_stages([*earlier, last], preset.place)
        function, callback_name = find_callback(callback)
    env = environments[-1]
    run_name = (
        f"{env.name}_{short_name(config.algorithm)}_{short_name(config.reward)}_seed{config.seed}"
    )
    path = Path(run_dir) if run_dir else new_folder(run_name)
    result = train(
        env,
        config,
        path,
        provenance=last.provenance,
        loggers=run.loggers,
        asked={"episodes": episodes, **callback_name},
        callback=function,
        earlier=earlier,
    )
    _finish(result, env, config, episodes)


def _list_keys(config: "Config") -> None:
    """Prints the settings of a configuration with their values.

    Of a setting that nothing reads, also says when it would be read.
    """
    for name, value in config.model_dump(mode="json", exclude={"own"}).items():
        condition = config.unread.get(name)
        note = f"  # read where {condition.setting} is {condition.values}" if condition else ""
        click.echo(f"{name} = {json.dumps(value)}{note}")
    settings = dict(config.own)
    for name, default, hook in taken_settings(config.hooks):
        value = json.dumps(settings.get(name, default), default=str)
        click.echo(f"{OWN}{name} = {value}  # of {hook}")


def extent_of(config: "Config") -> str:
    """Returns how much the run trains: whole updates, which may be more than `total_timesteps`."""
    steps = config.num_updates * config.steps_per_update
    extent = f"{steps:,} environment steps"
    if config.seeds > 1:
        extent += " of each seed"
    if steps != config.total_timesteps:
        extent += f" (total_timesteps={config.total_timesteps:,} is rounded up to whole updates)"
    plural = "" if config.num_updates == 1 else "s"
    return (
        f"training {extent}: {config.num_updates:,} update{plural} of "
        f"{config.num_envs} environments x {config.num_steps} steps"
    )


def _resume(
    path: Path,
    game: str | None,
    map_file: str | None,
    episodes: int | None,
    loggers: "tuple[LoggerName, ...] | None",
    callback: str | None,
    total_timesteps: str | None,
) -> None:
    """Continues a run. `game`, `map_file`: where its game and map are now."""
    manifest = read_manifest(path)
    asked = manifest.get("asked", {})
    from sjdsl.trainers import resume

    check_loggers(manifest.get("loggers", ()) if loggers is None else loggers)
    if episodes is None:
        episodes = asked.get("episodes", EPISODES)
    if "game" not in manifest.get("provenance", {}):
        raise click.ClickException(
            f"the manifest of {path} doesn't say which game was trained; "
            f"resume the run from Python: sjdsl.trainers.resume(env, {str(path)!r})"
        )
    if total_timesteps is None and manifest.get("status") == "finished":
        click.echo(
            f"the run in {path} is finished, so it is only evaluated again; sjdsl train "
            f"--resume {shlex.quote(str(path))} --set total_timesteps=… makes it longer",
            err=True,
        )
    if callback is None and asked.get("callback") is not None:
        callback = asked["callback"]
        require_allowed("callback", callback, str(path / "manifest.json"))
    command = f"sjdsl train GAME --resume {shlex.quote(str(path))}"
    game_hash = manifest["game"].get("hash", "")
    provenance = locate(manifest["provenance"], game_hash, path, command, game, map_file)
    earlier = []  # arguments of `make_environment` for each earlier stage
    for folder in stage_folders(path)[:-1]:
        stage = read_manifest(folder)
        stage_hash = stage["game"].get("hash", "")
        earlier.append(locate(stage["provenance"], stage_hash, folder, command, game))
    with stages(LOADING), without_quoting_game(path / "manifest.json"):
        env = make_environment(provenance)
        environments = [make_environment(arguments) for arguments in earlier]
    function, callback_name = find_callback(callback)
    total = None
    if total_timesteps is not None:
        total = make_config(total_timesteps=total_timesteps).total_timesteps
    result = resume(
        env,
        path,
        loggers=loggers,
        asked={"episodes": episodes, **callback_name},
        callback=function,
        total_timesteps=total,
        provenance=provenance,
        earlier=environments,
    )
    _finish(result, env, stored_config(read_manifest(path)["config"]), episodes)


def find_callback(name: str | None) -> tuple[Any, dict[str, str]]:
    """Returns a callback by its name (`FILE.py:NAME`), and the entry of the manifest that names it;
    None and no entry without a name.
    """
    if name is None:
        return None, {}
    return find("callback", name), {"callback": absolute_name("callback", name)}


def _finish(result: "Result", env: "Environment", config: "Config", episodes: int) -> None:
    """Evaluates each seed's policy, and prints the time and memory of the run."""
    import jax

    if jax.process_index() != 0:
        return
    if result.stage:
        path = shlex.quote(str(result.run_dir.parents[1]))
        click.echo(
            f"\nthe callback ended the run in stage {result.stage}; sjdsl train --resume {path} "
            "continues it"
        )
        return
    completed = []
    for folder, seed in zip(result.folders, config.seed_numbers, strict=True):
        if episodes:
            evaluate_run(folder, env, episodes, seed)
        if seed not in result.diverged:
            completed.append(folder)
    (last,) = deque(read_rows(completed[0] / METRICS_JSONL), maxlen=1)
    steps_of_seed = result.updates * config.steps_per_update
    speed = rate(last, config.seeds, last["env_steps"] - steps_of_seed)
    stage = "the last stage: " if "stage" in last else ""
    click.echo(
        f"\n{stage}{steps_of_seed * config.seeds:,} environment steps in {last['seconds']:,.1f} s: "
        f"{speed:,.0f} steps a second; compiling took {result.compile_seconds:.1f} s; "
        f"at most {result.peak_megabytes:,.0f} MB of memory"
    )
    if not is_installed("matplotlib"):
        click.echo(f"no learning curve was drawn: {MissingExtra('matplotlib', 'plots')}")
    elif not any((folder / LEARNING_CURVE).exists() for folder in result.folders):
        click.echo(
            "no learning curve was drawn, as no episode ended within the "
            f"{config.num_steps * result.updates:,} steps of each environment"
        )
    for update, seeds in seeds_of_each(result.diverged.items()).items():
        click.echo(
            f"{seeds_in_words(seeds)} diverged (non-finite loss) in update {update}; "
            f"the policy of update {update - 1} is kept"
        )
    list_files(result.run_dir)


def join_processes() -> None:
    """Joins the other processes, by the environment variables of a cluster or JAX's own."""
    import os

    import jax

    arguments: dict[str, Any] = {}
    try:
        if "JAX_COORDINATOR_ADDRESS" in os.environ:
            arguments["coordinator_address"] = os.environ["JAX_COORDINATOR_ADDRESS"]
        if "JAX_NUM_PROCESSES" in os.environ:
            arguments["num_processes"] = int(os.environ["JAX_NUM_PROCESSES"])
        if "JAX_PROCESS_ID" in os.environ:
            arguments["process_id"] = int(os.environ["JAX_PROCESS_ID"])
        jax.distributed.initialize(**arguments)
    except (ValueError, RuntimeError) as error:
        raise click.ClickException(
            f"can't join the other processes: {error}; outside a cluster, set "
            "JAX_COORDINATOR_ADDRESS, JAX_NUM_PROCESSES, JAX_PROCESS_ID"
        ) from None


def _choose_preset(game: str | None, run: RunOptions, needed: bool) -> Preset:
    """Returns the preset with the changes of the command line; without a preset, the game and the
    configuration as one.

    needed: whether a game must be named.
    """
    if run.preset is None:
        if game is None and needed:
            raise click.UsageError(
                "name the game to train in, as in `sjdsl train clean_up`, or a preset that names "
                "one"
            )
        return Preset(game, {}, make_config(run.settings))
    preset = load_preset(run.preset, run.settings, game)
    if preset.game is None and needed:
        raise click.UsageError(
            f"the preset `{run.preset}` doesn't name a game: name one, as in "
            f"`sjdsl train clean_up --preset {run.preset}`"
        )
    for name in preset.left_out:
        if name.startswith(OWN):
            reason = ": no hook takes it"
        else:
            condition = preset.config.unread.get(name)
            setting = condition.setting if condition else "algorithm"
            reason = f" while `{setting}` is {getattr(preset.config, setting)}"
        click.echo(f"the preset's `{name}` has no effect{reason}", err=True)
    return preset


def new_folder(name: str) -> Path:
    """Returns a new folder in `runs`: `name`, or `name_2`, `name_3` and so on."""
    path = Path("runs") / name
    number = 1
    while path.exists():
        number += 1
        path = Path("runs") / f"{name}_{number}"
    return path
