"""`sjdsl train`: agents that learn in a game, and what they are worth beside random ones."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment import describe_environment, environment_options, make_environment, read_assignments
from sjdsl.cli.evaluate import evaluate_run, list_files

if TYPE_CHECKING:
    from sjdsl.trainers import Config


@click.command("train")
@click.argument("game", required=False)
@click.option("--algorithm", type=click.Choice(["ippo"]), default="ippo", show_default=True)
@click.option("--reward", type=click.Choice(["individual", "common"]), help="Whose reward an agent learns from.")
@click.option("--preset", metavar="P", help="A preset such as quick, or a .toml file; it may name the game.")
@click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="NAME=VALUE",
    help="A value of the configuration, such as total_timesteps=1e6.",
)
@click.option("--seed", type=click.IntRange(min=0), help="0 unless the preset has another.")
@click.option("--run", "run_dir", metavar="DIR", help="Where the run's files go; by default a new folder in runs/.")
@click.option(
    "--episodes",
    type=click.IntRange(min=0),
    default=30,
    show_default=True,
    help="Episodes of the evaluation at the end; 0 for none.",
)
@environment_options
def command(
    game: str | None,
    algorithm: str,
    reward: str | None,
    preset: str | None,
    changes: tuple[str, ...],
    seed: int | None,
    run_dir: str | None,
    episodes: int,
    **described: Any,
) -> None:
    """Trains one network for all agents of GAME, a bundled game or a `.sj` file, and evaluates it.

    The run's folder gets a manifest, metrics, checkpoints, a learning curve and the evaluation.
    """
    from sjdsl.trainers import train

    given = {name: value for name, value in (("reward", reward), ("seed", seed)) if value is not None}
    game, kept, config = _choose(game, preset, {**read_texts(changes), **given})
    described["params"] = {**kept.pop("params", {}), **read_assignments(described["params"])}
    provenance = describe_environment(game, **described)
    provenance |= {name: value for name, value in kept.items() if provenance.get(name) is None}
    env = make_environment(provenance)
    path = Path(run_dir) if run_dir else new_folder(f"{env.name}_{algorithm}_{config.reward}_seed{config.seed}")
    train(env, config, path, provenance=provenance)
    if episodes:
        evaluate_run(path, env, episodes, config.seed)
    list_files(path)


def _choose(game: str | None, preset: str | None, changes: dict[str, str]) -> tuple[str, dict[str, Any], "Config"]:
    """Returns the game, the preset's other arguments of its environment, and the configuration."""
    from sjdsl.trainers import Config, load_preset

    if preset is None:
        if game is None:
            raise click.UsageError("name a game, or a preset that names one", click.get_current_context())
        return game, {}, Config(**changes)
    loaded = load_preset(preset, changes)
    same = game in (None, loaded.game)
    return game or loaded.game, dict(loaded.environment) if same else {}, loaded.config


def read_texts(given: tuple[str, ...]) -> dict[str, str]:
    """Returns `name=value` as a mapping of texts: the configuration knows what they mean."""
    pairs = [text.partition("=") for text in given]
    for text, (name, equals, _) in zip(given, pairs, strict=True):
        if not equals or not name:
            raise click.UsageError(f"`{text}` is not of the form name=value", click.get_current_context(silent=True))
    return {name.strip(): value.strip() for name, _, value in pairs}


def new_folder(name: str) -> Path:
    """Returns a folder in `runs` that does not exist: `name`, or `name_2`, `name_3` and so on."""
    number = 1
    while (path := Path("runs") / (name if number == 1 else f"{name}_{number}")).exists():
        number += 1
    return path
