"""The options that describe an environment, and the environment they describe."""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

import sjdsl
from sjdsl.cli.game_file import game_path, map_option, open_game, read_map, split_variants, variant_option
from sjdsl.compiler import Build, build_composition
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.games_folder import is_name
from sjdsl.interpreter.numbers import real
from sjdsl.parameters import param_values, split_sizes

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Encoding, Environment

Command = Callable[..., Any]
SEED = click.IntRange(0, 2**32 - 1)  # JAX makes a key of the lower 32 bits of a number: another beyond them would be one of these again


def environment_options(command: Command) -> Command:
    """Adds --variant, --map, --agents and --param to a command; they arrive as `variant`, `map_file`, `agents`, `params`."""
    number = click.option("--agents", type=click.IntRange(min=1), metavar="N", help="Number of agents, instead of the game's own.")
    params = click.option(
        "--param",
        "params",
        multiple=True,
        metavar="NAME=VALUE",
        help="A parameter of the game, such as apple=2 or regrow[red]=0.1.",
    )
    return variant_option(map_option(number(params(command))))


def read_assignments(given: tuple[str, ...]) -> dict[str, Any]:
    """Returns `name=value` and `name[word]=value` as a mapping, with one level for each bracket."""
    values: dict[str, Any] = {}
    for text in given:
        path, equals, value = text.partition("=")
        if not equals or not path.strip():
            raise click.UsageError(f"`{text}` must have the form name=value", click.get_current_context(silent=True))
        *outer, last = path.strip().replace("]", "").split("[")
        inner = values
        for name in outer:
            inner = inner.setdefault(name.strip(), {})
            if not isinstance(inner, dict):
                raise click.UsageError(
                    f"`{name}` is given as one number and also word by word; give it one way", click.get_current_context(silent=True)
                )
        if last.strip() in inner:
            refuse_second(path.strip())
        inner[last.strip()] = _read_value(value.strip())
    return values


def refuse_second(name: str) -> NoReturn:
    """Raises UsageError for a name that has a value already: which one is meant cannot be told."""
    raise click.UsageError(f"`{name}` is given twice; give it once", click.get_current_context(silent=True))


def _read_value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


def describe_environment(
    game: str, variant: str | None, map_file: str | None, agents: int | None, params: Mapping[str, Any]
) -> dict[str, Any]:
    """Returns the arguments of `make_environment` as values that JSON can hold and that hold in every folder."""
    path = game_path(game)
    return {
        "game": game if is_name(game) else str(path.resolve()),
        "variant": variant,
        "map": map_file and str(Path(map_file).resolve()),
        "num_agents": agents,
        "params": dict(params),
    }


def build_game(
    game: str, given: dict[str, Any], variant: str | None, map_file: str | None, agents: int | None
) -> tuple[Build, dict[str, Any]]:
    """Returns a checked game and its run-time numbers. Raises CompileError, and ValueError for numbers that do not fit it."""
    source = open_game(game)
    composition = compose(source, split_variants(variant))
    sizes, rest = split_sizes(*composition.number_names(), given)
    made = build_composition(composition, replace(read_map(map_file, source), sizes=sizes, num_agents=agents))
    if agents is not None and made.game.agents.number != agents:
        raise ValueError(f"--agents {agents}, but a size in --param says {made.game.agents.number}")
    types = {p.name: p.type for p in made.game.params}
    values = param_values(made.game, rest)
    return made, {name: real(value) if types[name].kind == "real" else value for name, value in values.items()}


def check_environment(game: str, variant: str | None, map_file: str | None, agents: int | None, params: Mapping[str, Any]) -> "ir.Game":
    """Returns the checked game, without importing JAX, which takes seconds. Raises CompileError, and ClickException for wrong arguments."""
    try:
        return build_game(game, dict(params), variant, map_file, agents)[0].game
    except ValueError as error:
        raise click.ClickException(str(error)) from None


def make_environment(described: Mapping[str, Any], observation: "Encoding" = "tokens") -> "Environment":
    """Returns the environment. Raises CompileError, and ClickException for arguments that do not fit the game."""
    try:
        return sjdsl.make(**described, observation=observation)
    except (ValueError, TypeError, FileNotFoundError) as error:
        if _is_ours(error):
            raise
        raise click.ClickException(str(error)) from None


@contextmanager
def named_in(file: Path | str) -> Iterator[None]:
    """Makes what is wrong with a game that a file names a ClickException: nobody has said that its texts, or its map's, may be shown."""
    try:
        yield
    except CompileError as error:
        found = dict.fromkeys(f"{d.code} {d.title}" for d in error.diagnostics if d.severity == "error")
        raise click.ClickException(
            f"{file} names a game, or a map for it, with errors: {', '.join(found)}; run `sjdsl check` on them to see where"
        ) from None
    except (ValueError, TypeError, KeyError, OverflowError, OSError) as error:
        raise click.ClickException(f"{file} names a game that cannot be built with the settings it gives: {error}") from None


def _is_ours(error: Exception) -> bool:
    """Returns whether an error comes from deeper than the checks of arguments: then it is a bug, and its traceback is wanted."""
    frames = []
    trace = error.__traceback__
    while trace is not None:
        frames.append(trace.tb_frame.f_globals.get("__name__", ""))
        trace = trace.tb_next
    return frames[-1] not in ("sjdsl.factory", "sjdsl.parameters", "sjdsl.games_folder")
