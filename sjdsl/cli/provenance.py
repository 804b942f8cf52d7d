"""How the environment of a run or an episode was made, and where its game is now."""

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import click

from sjdsl.cli.environment_options import without_quoting_game
from sjdsl.files import read_json
from sjdsl.library.stored_game import GameMoved, locate_game


def arguments_of_run(
    run_dir: Path, alternative: str = "", game: str | None = None, map_file: str | None = None
) -> dict[str, Any]:
    """Returns the arguments of `make_environment` for a run, or for one of its seeds.

    Args:
      alternative: what else the user can do: the end of a message about a folder that isn't a run.
      game, map_file: where the run's game and map are now, if the user says so.
    Raises:
      ClickException: there is no such folder, it isn't that of a run, its manifest doesn't name the
        game, or the game is missing.
    """
    path = run_dir / "manifest.json"
    if not path.is_file() and run_dir.is_dir() and (run_dir.parent / "manifest.json").is_file():
        path = run_dir.parent / "manifest.json"  # one seed of several
    if not run_dir.exists():
        raise click.ClickException(
            f"there is no folder `{run_dir}`; name the folder of a run that `sjdsl train` wrote"
            f"{alternative}"
        )
    if not path.is_file():
        raise click.ClickException(
            f"{run_dir} is not the folder of a training run: there is no manifest.json in it. "
            f"Name the folder that `sjdsl train` wrote{alternative}"
        )
    try:
        manifest = read_json(path)
        provenance = manifest.get("provenance") or {}
        game_hash = manifest.get("game", {}).get("hash", "")
    except (OSError, ValueError, AttributeError):
        raise click.ClickException(
            f"{path} can't be read: it isn't a manifest that `sjdsl train` wrote{alternative}"
        ) from None
    if not isinstance(provenance, dict) or "game" not in provenance:
        raise click.ClickException(
            f"the manifest of {run_dir} doesn't say which game was trained, because the run was "
            f"started from Python; evaluate it from Python too{alternative}"
        )
    command = f"sjdsl evaluate {run_dir} --game GAME"
    return locate(provenance, game_hash, run_dir, command, game, map_file)


def locate(
    stored: Mapping[str, Any],
    game_hash: str,
    path: Path,
    command: str,
    game: str | None = None,
    map_file: str | None = None,
) -> dict[str, Any]:
    """Returns the stored arguments of `make_environment`, with the paths that the files have now.

    Args:
      game_hash: the hash that the game must have.
      path: the file or folder that stores the arguments.
      command: how the user can say where the game is.
      game, map_file: where they are, if the user says so.
    Raises:
      ClickException: the files are missing, or have other rules.
    """
    try:
        with without_quoting_game(path) if game is None else nullcontext():
            arguments = locate_game(stored, game_hash, path, game, map_file)
    except GameMoved as error:
        raise click.ClickException(
            f"{error}; name the game with these rules: {command}, and --map FILE if it had a map "
            "of its own"
        ) from None
    except (ValueError, FileNotFoundError) as error:
        raise click.ClickException(str(error)) from None
    names = [name for name in ("game", "map") if arguments.get(name) != stored.get(name)]
    if names and game is None:
        files = " and ".join(str(arguments[name]) for name in names)
        click.echo(f"note: the game of {path} is found in {files}", err=True)
    return arguments
