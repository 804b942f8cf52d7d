"""Checks that a stopped run can be resumed, and refuses if it would continue differently."""

from pathlib import Path
from typing import Any

from ..environment import Environment
from ..settings.config import ConfigError, require_code, stored_config
from ..settings.extensions import NotAllowed
from ..settings.own_settings import unread_own
from .manifest import MANIFEST, read_manifest
from .run_errors import RunError
from .run_folder import describe_game, own_files, versions


def check_same_run(env: Environment, run_dir: Path) -> dict[str, Any]:
    """Returns the manifest of a run that can be resumed in `env`.

    Raises:
      RunError: there is no such run; its game had other rules or numbers; it was made by other
        versions, whose figures differ; it needs code that the caller hasn't allowed (`allow_code`).
    """
    manifest = read_manifest(run_dir)
    stored = manifest["game"]
    game = describe_game(env)
    if stored.get("hash") != game["hash"]:
        raise RunError(
            f"{run_dir} is a run of {stored.get('name')} with the rules {stored.get('hash')}, and "
            f"they are {game['hash']} now; restore the file, or start a new run"
        )
    params = stored.get("params", {})
    if params != game["params"]:
        changed = [name for name, value in game["params"].items() if params.get(name) != value]
        raise RunError(
            f"{run_dir} is a run with other numbers of the game: "
            f"{', '.join(changed) or 'some are gone'}"
        )
    for part in ("tasks", "split"):
        if stored.get(part) != game.get(part):
            raise RunError(
                f"{run_dir} was trained with {part}={stored.get(part)}: make the environment with "
                f"the same, not with {part}={game.get(part)}"
            )
    installed = versions()
    others = [
        f"{name} {version} (here {installed.get(name)})"
        for name, version in manifest["versions"].items()
        if installed.get(name) != version
    ]
    if others:
        raise RunError(
            f"{run_dir} was made with {', '.join(others)}; its figures would come out differently: "
            "install those, or start a new run"
        )
    try:
        config = stored_config(manifest["config"], strict=True)
        require_code(config, str(run_dir / MANIFEST), to_act=False)
        files = own_files(config)
        stored_files = manifest.get("own_files", {})
        changed = [name for name, digest in stored_files.items() if files.get(name) != digest]
        if changed:
            raise RunError(
                f"{', '.join(changed)} has changed since {run_dir} was started: "
                "restore the file, or start a new run"
            )
        for message in unread_own(config.hooks, config.own).values():
            raise ConfigError(message)
    except NotAllowed as error:
        raise RunError(str(error)) from None
    # a hook that isn't registered, or isn't in its file; a partner's name that isn't a path
    except (ConfigError, OSError, ValueError) as error:
        raise RunError(f"{run_dir / MANIFEST} has an invalid configuration: {error}") from None
    return manifest


def extend_manifest(
    manifest: dict[str, Any], run_dir: Path, total_timesteps: int
) -> dict[str, Any]:
    """Returns the manifest of a run that takes so many environment steps in all.

    Raises:
      RunError: it has done more already.
    """
    before = stored_config(manifest["config"]).total_timesteps
    longer = stored_config({**manifest["config"], "total_timesteps": total_timesteps})
    done = manifest.get("updates", 0)
    if longer.num_updates < done or longer.total_timesteps < before:
        raise RunError(
            f"{run_dir} is a run of {before:,} steps that has done "
            f"{done * longer.steps_per_update:,}; a run can only be made longer: "
            f"total_timesteps must be more, not {longer.total_timesteps:,}"
        )
    note = {"from": before, "to": longer.total_timesteps, "updates": done}
    return manifest | {
        "config": longer.record(),
        "derived": manifest.get("derived", {}) | {"updates": longer.num_updates},
        "extended": [*manifest.get("extended", []), note],
    }
