"""Resumes a stopped run from its latest readable checkpoint, and refuses if the run would differ."""

import warnings
from pathlib import Path
from typing import Any

from .checkpoints import CheckpointError, Checkpoints
from .compiled import Compiled
from .config import ConfigError, require_code, stored_config
from .environment import Environment
from .extensions import NotAllowed
from .manifest import MANIFEST, read_manifest
from .own_settings import unread_own
from .run_errors import RunError
from .run_folder import describe_game, own_files, versions
from .training_functions import TrainState


def check_same_run(env: Environment, run_dir: Path) -> dict[str, Any]:
    """Returns the manifest of a run that can be gone on with in `env`.

    Raises:
      RunError: there is no such run; its game had other rules or numbers; it was made by other versions, whose figures differ; it needs
        code that the caller has not named (`allow_code`).
    """
    manifest = read_manifest(run_dir)
    then, now = manifest["game"], describe_game(env)
    if then.get("hash") != now["hash"]:
        raise RunError(
            f"{run_dir} is a run of {then.get('name')} with the rules {then.get('hash')}, and they are {now['hash']} now; "
            "go on with the file as it was, or start a new run"
        )
    params = then.get("params", {})
    if params != now["params"]:
        changed = [name for name in now["params"] if params.get(name) != now["params"][name]]
        raise RunError(f"{run_dir} is a run with other numbers of the game: {', '.join(changed) or 'some are gone'}")
    known = versions()
    other = {name: version for name, version in manifest["versions"].items() if known.get(name) != version}
    if other:
        listed = ", ".join(f"{name} {version} (here {known.get(name)})" for name, version in other.items())
        raise RunError(f"{run_dir} was made with {listed}; its figures would not go on alike: install those, or start a new run")
    try:
        config = stored_config(manifest["config"], strict=True)
        require_code(config, str(run_dir / MANIFEST), to_act=False)
    except NotAllowed as error:
        raise RunError(str(error)) from None
    except (ConfigError, OSError, ValueError) as error:  # the name of a partner may be no path
        raise RunError(f"{run_dir / MANIFEST} has a configuration that is none: {error}") from None
    files = own_files(config)
    changed = [name for name, digest in manifest.get("own_files", {}).items() if files.get(name) != digest]
    if changed:
        raise RunError(f"{', '.join(changed)} has changed since {run_dir} was started: go on with the file as it was, or start a new run")
    try:
        unread = unread_own(config)
    except ConfigError as error:  # a hook that is not registered, or not in its file
        raise RunError(f"{run_dir / MANIFEST} has a configuration that is none: {error}") from None
    for said in unread.values():
        raise RunError(f"{run_dir / MANIFEST} has a configuration that is none: {said}")
    return manifest


def extended(manifest: dict[str, Any], run_dir: Path, total_timesteps: int) -> dict[str, Any]:
    """Returns the manifest of a run that is to take so many environment steps in all.

    Raises:
      RunError: it has done them already.
    """
    before = stored_config(manifest["config"]).total_timesteps
    longer = stored_config({**manifest["config"], "total_timesteps": total_timesteps})
    done = manifest.get("updates", 0)
    if longer.num_updates < done or longer.total_timesteps < before:
        raise RunError(
            f"{run_dir} is a run of {before:,} steps that has done {done * longer.steps_per_update:,}; a run can be "
            f"made longer, not shorter: total_timesteps must be more, not {longer.total_timesteps:,}"
        )
    note = {"from": before, "to": longer.total_timesteps, "updates": done}
    return manifest | {
        "config": longer.record(),
        "derived": manifest.get("derived", {}) | {"updates": longer.num_updates},
        "extended": [*manifest.get("extended", []), note],
    }


def restore_last(checkpoints: Checkpoints, compiled: Compiled) -> tuple[TrainState, int]:
    """Returns the state to go on from and the updates done until then: the first state where there is no checkpoint.

    A checkpoint that cannot be read is told of and removed, for the run, which comes to the same figures again, to write it anew.
    """
    start = compiled.start()
    for update in checkpoints.updates():
        try:
            return checkpoints.restore(update, start)[0], update
        except CheckpointError as error:
            warnings.warn(f"{error}; going on from the one before", stacklevel=2)
            checkpoints.drop(update)
    return start, 0
