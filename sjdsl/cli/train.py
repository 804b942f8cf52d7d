"""`sjdsl train`: trains agents in a game, and compares them with random ones."""

import json
import shlex
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.configuration_options import check_policies, configuration_options, log_option, read_configuration, read_texts
from sjdsl.cli.environment_options import (
    check_environment,
    describe_environment,
    environment_options,
    make_environment,
    named_in,
    read_assignments,
)
from sjdsl.cli.evaluate import evaluate_run, list_files
from sjdsl.cli.stages import LOADING, stages
from sjdsl.trainers import load_preset, make_config
from sjdsl.trainers.config import stored_config
from sjdsl.trainers.extensions import find, lasting, require_allowed, short_name
from sjdsl.trainers.manifest import read_manifest
from sjdsl.trainers.own_settings import OWN, taken_settings
from sjdsl.trainers.run_lock import is_unused

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment
    from sjdsl.trainers import Config, Result
    from sjdsl.trainers.loggers import LoggerName

EPISODES = 30  # of the evaluation at the end


@click.command("train")
@click.argument("game", required=False)
@configuration_options
@click.option("--seeds", type=click.IntRange(min=1), metavar="K", help="Train K seeds side by side: seed, seed + 1 and so on.")
@click.option("--run", "run_dir", metavar="DIR", help="Where the run's files go; by default a new folder in runs/.")
@click.option(
    "--resume", "resumed", metavar="DIR", help="Continue the stopped run in DIR; with --set total_timesteps=…, extend a finished one."
)
@click.option(
    "--episodes",
    type=click.IntRange(min=0),
    metavar="N",
    help="Episodes of the evaluation at the end; 0 for none.  [default: 30, or as the run that is resumed was started]",
)
@log_option
@click.option("--callback", metavar="FILE.py:NAME", help="Your own function, called after each update.")
@click.option("--distributed", is_flag=True, help="One of several processes that train together; see docs/training.md.")
@click.option("--keys", is_flag=True, help="List the configuration's keys with their values, and stop.")
@environment_options
def command(
    game: str | None,
    algorithm: str | None,
    reward: str | None,
    preset: str | None,
    changes: tuple[str, ...],
    seed: int | None,
    seeds: int | None,
    run_dir: str | None,
    resumed: str | None,
    episodes: int | None,
    loggers: "tuple[LoggerName, ...]",
    init_from: str | None,
    partners: tuple[str, ...],
    callback: str | None,
    distributed: bool,
    keys: bool,
    **described: Any,
) -> None:
    """Trains agents in GAME, a bundled or installed game or a `.sj` file, and evaluates them.

    The run's folder gets a manifest, metrics, checkpoints, policies, a learning curve and the evaluation.
    """
    known = read_configuration(algorithm, reward, seed, seeds, init_from, partners)
    if distributed:
        join_processes()
    if resumed is not None:
        longer = read_texts(changes).get("total_timesteps")
        others = tuple(name for name in read_texts(changes) if name != "total_timesteps")
        ours: dict[str, Any] = {"GAME": game, "--preset": preset, "--set": others, "--run": run_dir}
        known = {name.replace("_", "-"): value for name, value in known.items()}
        theirs = {name.removesuffix("_file").replace("params", "param"): value for name, value in described.items()}
        _refuse_beside_resume({**known, **ours, **theirs})
        _resume(Path(resumed), episodes, loggers or None, callback, longer)
        return
    game, kept, config = _choose(game, preset, {**read_texts(changes), **known}, needed=not keys)
    if keys:
        _list_keys(config)
        return
    described["params"] = {**kept.pop("params", {}), **read_assignments(described["params"])}
    provenance = describe_environment(game, **described)
    provenance |= {name: value for name, value in kept.items() if provenance.get(name) is None}
    checked = check_environment(game, provenance["variant"], provenance["map"], provenance["num_agents"], provenance["params"])
    check_policies(config, checked)
    if not distributed:  # then another process may have begun to write there
        _require_unused(run_dir)
    _start(provenance, config, run_dir, EPISODES if episodes is None else episodes, loggers, callback)


def _list_keys(config: "Config") -> None:
    """Prints the settings of a configuration with their values, and of those that nothing reads now when they are read."""
    for name, value in config.model_dump(mode="json", exclude={"own"}).items():
        mark = config.unread.get(name)
        click.echo(f"{name} = {json.dumps(value)}" + (f"  # read where {mark.setting} is {mark.values}" if mark else ""))
    given = dict(config.own)
    for name, default, hook in taken_settings(config):
        click.echo(f"{OWN}{name} = {json.dumps(given.get(name, default), default=str)}  # of {hook}")


def _require_unused(run_dir: str | None) -> None:
    """Refuses a folder that `train` would refuse, before JAX is imported."""
    path = Path(run_dir or "")
    if run_dir and not is_unused(path):
        raise click.ClickException(
            f"{run_dir} is not empty; name a new folder, so that no earlier run is lost, or go on with the run in it: "
            f"sjdsl train --resume {shlex.quote(run_dir)}"
        )


def _start(
    provenance: dict[str, Any],
    config: "Config",
    run_dir: str | None,
    episodes: int,
    loggers: "tuple[LoggerName, ...]",
    callback: str | None,
) -> None:
    click.echo(extent_of(config), err=True)
    with stages(LOADING):
        from sjdsl.trainers import train
        from sjdsl.trainers.loggers import check_loggers

        check_loggers(loggers)
        env = make_environment(provenance)
        found, asked = find_callback(callback)
    path = (
        Path(run_dir) if run_dir else new_folder(f"{env.name}_{short_name(config.algorithm)}_{short_name(config.reward)}_seed{config.seed}")
    )
    result = train(env, config, path, provenance=provenance, loggers=loggers, asked={"episodes": episodes, **asked}, callback=found)
    _finish(result, env, config, episodes)


def extent_of(config: "Config") -> str:
    """Returns how much is trained: whole updates, which may be more than `total_timesteps`."""
    steps, updates = config.num_updates * config.steps_per_update, config.num_updates
    plan = f"{updates:,} update{'s' * (updates != 1)} of {config.num_envs} environments x {config.num_steps} steps"
    what = f"{steps:,} environment steps{' of each seed' if config.seeds > 1 else ''}"
    if steps == config.total_timesteps:
        return f"training {what}: {plan}"
    return f"training {what} (total_timesteps={config.total_timesteps:,} is rounded up to whole updates): {plan}"


def _resume(path: Path, episodes: int | None, loggers: "tuple[LoggerName, ...] | None", callback: str | None, longer: str | None) -> None:
    from sjdsl.trainers import resume
    from sjdsl.trainers.loggers import check_loggers

    manifest = read_manifest(path)
    check_loggers(manifest.get("loggers", ()) if loggers is None else loggers)
    if episodes is None:
        episodes = manifest.get("asked", {}).get("episodes", EPISODES)
    if "game" not in manifest.get("provenance", {}):
        raise click.ClickException(
            f"the manifest of {path} does not say which game was trained; go on with the run from Python: sjdsl.trainers.resume(env, {str(path)!r})"
        )
    if longer is None and manifest.get("status") == "finished":
        click.echo(
            f"the run in {path} is finished, and is evaluated again; "
            f"sjdsl train --resume {shlex.quote(str(path))} --set total_timesteps=… makes it longer",
            err=True,
        )
    kept = manifest.get("asked", {}).get("callback")
    if callback is None and kept is not None:
        require_allowed("callback", kept, str(path / "manifest.json"))
    with stages(LOADING), named_in(path / "manifest.json"):
        env = make_environment(manifest["provenance"])
    found, asked = find_callback(callback or kept)
    total = None if longer is None else make_config(total_timesteps=longer).total_timesteps
    result = resume(env, path, loggers=loggers, asked={"episodes": episodes, **asked}, callback=found, total_timesteps=total)
    _finish(result, env, stored_config(read_manifest(path)["config"]), episodes)


def find_callback(name: str | None) -> tuple[Any, dict[str, str]]:
    """Returns the callback of a name, and the name as it is kept in a manifest."""

    return (None, {}) if name is None else (find("callback", name), {"callback": lasting("callback", name)})


def _finish(result: "Result", env: "Environment", config: "Config", episodes: int) -> None:
    """Evaluates each seed's policy, and says what the run took."""
    import jax

    from sjdsl.trainers.learning_curve import LEARNING_CURVE
    from sjdsl.trainers.metrics_files import METRICS_JSONL, read_rows
    from sjdsl.trainers.progress import rate

    if jax.process_index() != 0:
        return
    for folder, seed in zip(result.folders, config.seed_numbers, strict=True):
        if episodes:
            evaluate_run(folder, env, episodes, seed)
    went_on = next(folder for folder, seed in zip(result.folders, config.seed_numbers, strict=True) if seed not in result.diverged)
    (last,) = deque(read_rows(went_on / METRICS_JSONL), maxlen=1)
    steps = result.updates * config.steps_per_update * config.seeds
    click.echo(
        f"\n{steps:,} environment steps in {last['seconds']:,.1f} s: {rate(last, config.seeds):,.0f} steps a second; "
        f"compiling took {result.compile_seconds:.1f} s; at most {result.peak_megabytes:,.0f} MB of memory"
    )
    if not any((folder / LEARNING_CURVE).exists() for folder in result.folders):
        click.echo(
            f"no learning curve was drawn, for no episode ended within the {config.num_steps * result.updates:,} steps of each environment"
        )
    for seed, update in result.diverged.items():
        click.echo(f"seed {seed} stopped in update {update}, for its loss became nan; its policy is that of update {update - 1}")
    list_files(result.run_dir)


def _refuse_beside_resume(given: dict[str, Any]) -> None:
    wrong = [name if name.startswith("--") or name == "GAME" else f"--{name}" for name, value in given.items() if value not in (None, ())]
    if wrong:
        said = f"a resumed run goes on as it was started, but for its total_timesteps: leave out {', '.join(wrong)}"
        raise click.UsageError(said, click.get_current_context())


def join_processes() -> None:
    """Joins the processes that the environment variables of a cluster, or JAX's own, name."""
    import os

    import jax

    given = {"coordinator_address": "JAX_COORDINATOR_ADDRESS", "num_processes": "JAX_NUM_PROCESSES", "process_id": "JAX_PROCESS_ID"}
    found = {name: os.environ[variable] for name, variable in given.items() if variable in os.environ}
    numbers: dict[str, Any] = {name: value if name == "coordinator_address" else int(value) for name, value in found.items()}
    try:
        jax.distributed.initialize(**numbers)
    except (ValueError, RuntimeError) as error:
        wanted = ", ".join(given.values())
        raise click.ClickException(f"cannot join the other processes: {error}; outside a cluster set {wanted}") from None


def _choose(game: str | None, preset: str | None, changes: dict[str, Any], needed: bool) -> tuple[str, dict[str, Any], "Config"]:
    """Returns the game, the preset's other arguments of its environment, and the configuration."""

    if preset is None:
        if game is None and needed:
            raise click.UsageError(
                "name the game to train in, as in `sjdsl train clean_up`, or a preset that names one", click.get_current_context()
            )
        return game or "", {}, make_config(changes)
    loaded = load_preset(preset, changes, game)
    if loaded.game is None and needed:
        raise click.UsageError(
            f"the preset `{preset}` does not name a game: name one, as in `sjdsl train clean_up --preset {preset}`",
            click.get_current_context(),
        )
    for name in loaded.left_out:
        mark = loaded.config.unread.get(name)
        where = f" where `{mark.setting}` is {getattr(loaded.config, mark.setting)}" if mark else ": no hook takes it"
        click.echo(f"the preset's `{name}` does nothing{where}", err=True)
    return loaded.game or "", dict(loaded.environment), loaded.config


def new_folder(name: str) -> Path:
    """Returns a folder in `runs` that does not exist: `name`, or `name_2`, `name_3` and so on."""
    number = 1
    while (path := Path("runs") / (name if number == 1 else f"{name}_{number}")).exists():
        number += 1
    return path
