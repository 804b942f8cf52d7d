"""How the environment of a run was made, as its manifest says."""

from pathlib import Path
from typing import Any

import click

from sjdsl.files import read_json


def provenance_of(run_dir: Path, otherwise: str = "") -> dict[str, Any]:
    """Returns the arguments of `make_environment` for a run, or for one of its seeds.

    Args:
      otherwise: what else the user may do, which ends the message where there is no run.
    Raises:
      ClickException: there is no such folder, it is that of no run, or the run does not know its game.
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
        raise click.ClickException(f"{path} cannot be read: it is no manifest that `sjdsl train` wrote{otherwise}") from None
    if not isinstance(provenance, dict) or "game" not in provenance:
        raise click.ClickException(
            f"the manifest of {run_dir} does not say which game was trained, for the run was started from Python; "
            f"evaluate it from Python, too{otherwise}"
        )
    return provenance
