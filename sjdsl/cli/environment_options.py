"""The options that describe an environment, and the environment they describe."""

import functools
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

import sjdsl
from sjdsl.cli.game_file import game_path, map_option, variant_option
from sjdsl.compiler import Build
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.interpreter.numbers import real
from sjdsl.library.checked_game import build_game
from sjdsl.library.games_folder import is_name
from sjdsl.library.parameters import param_values

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Encoding, Environment

Command = Callable[..., Any]
SEED = click.IntRange(
    0, 2**32 - 1
)  # JAX makes keys from the lower 32 bits, so a larger seed would repeat one of these


@dataclass(frozen=True)
class EnvironmentOptions:
    """The values of --variant, --map, --agents and --param: the arguments of `sjdsl.make` other than the game."""

    variant: str | None = None
    map: str | None = None  # a file
    num_agents: int | None = None
    params: Mapping[str, Any] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """The options that were given, by the names of their arguments; numbers of the game as `param.X`."""
        given = [
            name for name in ("variant", "map", "num_agents") if getattr(self, name) is not None
        ]
        return [*given, *(f"param.{name}" for name in self.params)]

    def describe(self, game: str) -> dict[str, Any]:
        """Returns the arguments of `make_environment` as JSON values that mean the same in every folder."""
        path = game_path(game)
        return {
            "game": game if is_name(game) else str(path.resolve()),
            "variant": self.variant,
            "map": self.map and str(Path(self.map).resolve()),
            "num_agents": self.num_agents,
            "params": dict(self.params),
        }

    def read(self, game: str) -> tuple[Build, dict[str, Any]]:
        """Returns the checked game and its run-time numbers, without JAX, which takes seconds to load.

        Raises CompileError, and ValueError for numbers that don't fit the game.
        """
        try:
            made, given = build_game(
                game_path(game), self.variant, self.num_agents, self.params, self.map
            )
        except FileNotFoundError as error:
            raise click.ClickException(str(error)) from None
        types = {p.name: p.type for p in made.game.params}
        return made, {
            name: real(value) if types[name].kind == "real" else value
            for name, value in param_values(made.game, given).items()
        }

    def build(self, game: str) -> tuple[Build, dict[str, Any]]:
        """Returns what `read` does. Raises CompileError, and ClickException for numbers that don't fit the game."""
        try:
            return self.read(game)
        except ValueError as error:
            raise click.ClickException(str(error)) from None

    def check(self, game: str) -> "ir.Game":
        """Returns the checked game; raises what `build` raises."""
        return self.build(game)[0].game

    def make(self, game: str) -> "Environment":
        """Returns the environment of a game that `check` accepts."""
        return make_environment(self.describe(game))

    def or_else(self, preset: Mapping[str, Any]) -> "EnvironmentOptions":
        """Returns these options, with a preset's in place of those that weren't given; the game's numbers are merged one by one."""
        given = {name: value for name, value in vars(self).items() if value is not None}
        return EnvironmentOptions(
            **{**preset, **given, "params": {**preset.get("params", {}), **self.params}}
        )


def environment_options(command: Command) -> Command:
    """Adds --variant, --map, --agents and --param; the command gets them together as `options`."""

    @functools.wraps(command)
    def with_options(
        *,
        variant: str | None,
        map_file: str | None,
        agents: int | None,
        params: tuple[str, ...],
        **others: Any,
    ) -> Any:
        return command(
            options=EnvironmentOptions(variant, map_file, agents, read_assignments(params)),
            **others,
        )

    number = click.option(
        "--agents", type=click.IntRange(min=1), metavar="N", help="The number of agents."
    )
    params = click.option(
        "--param",
        "params",
        multiple=True,
        metavar="NAME=VALUE",
        help="A number of the game: apple=2, regrow[red]=0.1.",
    )
    return variant_option(map_option(number(params(with_options))))


def written_options(*but: str) -> list[str]:
    """Returns the options and arguments given on the command line, as they are written there, without the parameters in `but`."""
    context = click.get_current_context()
    return [
        max(parameter.opts, key=len)
        if isinstance(parameter, click.Option)
        else parameter.make_metavar(context).strip("[]")
        for parameter in context.command.params
        if parameter.name not in but
        and context.get_parameter_source(parameter.name or "")
        is click.core.ParameterSource.COMMANDLINE
    ]


def read_texts(given: tuple[str, ...]) -> dict[str, str]:
    """Returns `name=value` as a mapping of texts."""
    values: dict[str, str] = {}
    for text in given:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name:
            raise click.UsageError(f"`{text}` must have the form name=value")
        if name in values:
            _refuse_second(name)
        values[name] = value
    return values


def read_assignments(given: tuple[str, ...]) -> dict[str, Any]:
    """Returns `name=value` and `name[word]=value` as a mapping, with a level for each bracket; values are JSON, or text."""
    values: dict[str, Any] = {}
    for text in given:
        ((path, value),) = read_texts((text,)).items()
        *outer, last = (word.strip() for word in path.replace("]", "").split("["))
        inner = values
        for name in outer:
            inner = inner.setdefault(name, {})
            if not isinstance(inner, dict):
                raise click.UsageError(
                    f"`{name}` is given both as one number and word by word; give it one way"
                )
        if last in inner:
            _refuse_second(path)
        try:
            inner[last] = json.loads(value)
        except ValueError:
            inner[last] = value
    return values


def _refuse_second(name: str) -> NoReturn:
    """Raises UsageError for a name that has a value already."""
    raise click.UsageError(f"`{name}` is given twice; give it once")


def make_environment(
    described: Mapping[str, Any], observation: "Encoding" = "tokens"
) -> "Environment":
    """Returns the environment. Raises CompileError, and ClickException for arguments that don't fit the game."""
    try:
        return sjdsl.make(**described, observation=observation)
    except (ValueError, TypeError, FileNotFoundError) as error:
        raise click.ClickException(str(error)) from error


@contextmanager
def named_in(file: Path | str) -> Iterator[None]:
    """Turns faults of a game that a file names into a ClickException, which shows no text of that game or its map."""
    try:
        yield
    except CompileError as error:
        found = dict.fromkeys(_without_text(d) for d in error.diagnostics if d.severity == "error")
        raise click.ClickException(
            f"{file} names a game, or a map for it, with errors: {', '.join(found)}; run `sjdsl check` on them to see where"
        ) from None
    except (ValueError, TypeError, KeyError, OverflowError, OSError) as error:
        raise click.ClickException(
            f"{file} names a game that can't be built with its settings: {error}"
        ) from None


def _without_text(fault: Diagnostic) -> str:
    """Returns a fault of a game without its text; that a file is missing is only found in what is a game."""
    return f"{fault.code} {fault.title}" + (f": {fault.message}" if fault.code == "SJ111" else "")
