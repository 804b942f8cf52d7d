"""How the environment of a run was made, from its manifest."""

from pathlib import Path
from typing import Any

import click

from sjdsl.files import read_json


def provenance_of(run_dir: Path, otherwise: str = "") -> dict[str, Any]:
    """Returns the arguments of `make_environment` for a run, or for one of its seeds.

    Args:
      otherwise: what else the user can do, to end the message with if there is no run.
    Raises:
      ClickException: there is no such folder, it isn't a run's, or the run doesn't know its game.
    """
    path = run_dir / "manifest.json"
    if not path.is_file() and run_dir.is_dir() and (run_dir.parent / "manifest.json").is_file():
        path = run_dir.parent / "manifest.json"  # one seed of several
    if not run_dir.exists():
        raise click.ClickException(f"there is no folder `{run_dir}`; name the folder of a run that `sjdsl train` wrote{otherwise}")
    if not path.is_file():
        raise click.ClickException(
            f"{run_dir} is not the folder of a training run: there is no manifest.json in it. Name the folder that `sjdsl train` wrote{otherwise}"
        )
    try:
        provenance = read_json(path).get("provenance") or {}
    except (OSError, ValueError, AttributeError):
        raise click.ClickException(f"{path} can't be read: it isn't a manifest that `sjdsl train` wrote{otherwise}") from None
    if not isinstance(provenance, dict) or "game" not in provenance:
        raise click.ClickException(
            f"the manifest of {run_dir} doesn't say which game was trained, because the run was started from Python; "
            f"evaluate it from Python too{otherwise}"
        )
    return provenance
