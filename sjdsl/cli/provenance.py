"""How the environment of a run or an episode was made, and where its game is now."""

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import click

from sjdsl.cli.environment_options import named_in
from sjdsl.files import read_json
from sjdsl.library.stored_game import GameMoved, locate_game


def provenance_of(
    run_dir: Path, otherwise: str = "", game: str | None = None, map_file: str | None = None
) -> dict[str, Any]:
    """Returns the arguments of `make_environment` for a run, or for one of its seeds.

    Args:
      otherwise: what else the user can do, to end the message with if there is no run.
      game, map_file: where the run's game and map are now, if the user says so.
    Raises:
      ClickException: there is no such folder, it isn't a run's, the run doesn't know its game, or that isn't found.
    """
    path = run_dir / "manifest.json"
    if not path.is_file() and run_dir.is_dir() and (run_dir.parent / "manifest.json").is_file():
        path = run_dir.parent / "manifest.json"  # one seed of several
    if not run_dir.exists():
        raise click.ClickException(
            f"there is no folder `{run_dir}`; name the folder of a run that `sjdsl train` wrote{otherwise}"
        )
    if not path.is_file():
        raise click.ClickException(
            f"{run_dir} is not the folder of a training run: there is no manifest.json in it. Name the folder that `sjdsl train` wrote{otherwise}"
        )
    try:
        manifest = read_json(path)
        provenance, rules = (
            manifest.get("provenance") or {},
            manifest.get("game", {}).get("hash", ""),
        )
    except (OSError, ValueError, AttributeError):
        raise click.ClickException(
            f"{path} can't be read: it isn't a manifest that `sjdsl train` wrote{otherwise}"
        ) from None
    if not isinstance(provenance, dict) or "game" not in provenance:
        raise click.ClickException(
            f"the manifest of {run_dir} doesn't say which game was trained, because the run was started from Python; "
            f"evaluate it from Python too{otherwise}"
        )
    return located(
        provenance, rules, run_dir, f"sjdsl evaluate {run_dir} --game GAME", game, map_file
    )


def located(
    stored: Mapping[str, Any],
    rules: str,
    place: Path,
    command: str,
    game: str | None = None,
    map_file: str | None = None,
) -> dict[str, Any]:
    """Returns the arguments of `make_environment` that `place` stores, with the paths that its files have now.

    Args:
      rules: the hash of the rules. command: with which the user can say where the game is. game, map_file: where they are.
    Raises:
      ClickException: they aren't found, or have other rules.
    """
    try:
        with named_in(place) if game is None else nullcontext():
            found = locate_game(stored, rules, place, game, map_file)
    except GameMoved as error:
        remedy = (
            f"name the game with these rules: {command}, and --map FILE if it had a map of its own"
        )
        raise click.ClickException(f"{error}; {remedy}") from None
    except (ValueError, FileNotFoundError) as error:
        raise click.ClickException(str(error)) from None
    moved = [str(found[name]) for name in ("game", "map") if found.get(name) != stored.get(name)]
    if moved and game is None:
        click.echo(f"note: the game of {place} is found in {' and '.join(moved)}", err=True)
    return found
