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
from sjdsl.cli.game_file import agents_option, game_path, map_option, variant_option
from sjdsl.compiler import Build
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.interpreter.numbers import real
from sjdsl.library.checked_game import build_game
from sjdsl.library.games_folder import is_name
from sjdsl.library.parameters import param_values
from sjdsl.library.tasks import MAX_PROBLEM, Tasks, replaced_tasks

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Encoding, Environment

Command = Callable[..., Any]


@dataclass(frozen=True)
class EnvironmentOptions:
    """The values of --variant, --map, --agents, --param, --tasks, --split and --problem: the
    arguments of `sjdsl.make` other than the game."""

    variant: str | None = None
    map: str | None = None  # a file
    num_agents: int | None = None
    params: Mapping[str, Any] = field(default_factory=dict)
    tasks: Tasks | None = None
    split: str | None = None
    problem: int | None = None

    @property
    def of_tasks(self) -> dict[str, Any]:
        """The arguments that say which tasks are played, without those that have no value."""
        arguments = {"tasks": self.tasks, "split": self.split, "problem": self.problem}
        return {name: value for name, value in arguments.items() if value is not None}

    @property
    def names(self) -> list[str]:
        """The names of the arguments that have a value; a parameter of the game is `param.X`."""
        arguments = ("variant", "map", "num_agents")
        names = [name for name in arguments if getattr(self, name) is not None]
        return [*names, *(f"param.{name}" for name in self.params), *self.of_tasks]

    def describe(self, game: str) -> dict[str, Any]:
        """Returns the arguments of `make_environment` as JSON values, with absolute paths."""
        path = game_path(game)
        return {
            "game": game if is_name(game) else str(path.resolve()),
            "variant": self.variant,
            "map": None if self.map is None else str(Path(self.map).resolve()),
            "num_agents": self.num_agents,
            "params": dict(self.params),
            **self.of_tasks,
        }

    def read(self, game: str) -> tuple[Build, dict[str, Any]]:
        """Returns the checked game and its run-time numbers. Doesn't load JAX, which takes seconds.

        Raises CompileError, and ValueError for numbers that don't fit the game.
        """
        try:
            built, run_time_params = build_game(
                game_path(game),
                self.variant,
                self.num_agents,
                self.params,
                self.map,
                **self.of_tasks,
            )
        except FileNotFoundError as error:
            raise click.ClickException(str(error)) from None
        values = param_values(built.game, run_time_params)
        for param in built.game.params:
            if param.type.kind == "real" and param.name in values:
                values[param.name] = real(values[param.name])
        return built, values

    def build(self, game: str) -> tuple[Build, dict[str, Any]]:
        """Returns what `read` does.

        Raises CompileError, and ClickException for numbers that don't fit the game.
        """
        try:
            return self.read(game)
        except ValueError as error:
            raise click.ClickException(str(error)) from None

    def check(self, game: str) -> "ir.Game":
        """Returns the checked game; raises what `build` raises."""
        build, _ = self.build(game)
        return build.game

    def make(self, game: str) -> "Environment":
        """Returns the environment of a game that `check` accepts."""
        return make_environment(self.describe(game))

    def or_else(self, preset: Mapping[str, Any]) -> "EnvironmentOptions":
        """Returns these options, with a preset's in place of those that have no value.

        The game's parameters are merged one by one; the tasks are replaced as one choice.
        """
        arguments = replaced_tasks(preset, self.of_tasks)
        arguments |= {name: value for name, value in vars(self).items() if value is not None}
        arguments["params"] = {**preset.get("params", {}), **self.params}
        return EnvironmentOptions(**arguments)


def environment_options(command: Command) -> Command:
    """Adds the options of an environment; the command gets them together as `options`."""

    @functools.wraps(command)
    def with_options(
        *,
        variant: str | None,
        map_file: str | None,
        agents: int | None,
        params: tuple[str, ...],
        tasks: tuple[str, ...],
        split: str | None,
        problem: int | None,
        **others: Any,
    ) -> Any:
        """Calls the command with the options in one object."""
        numbers = read_assignments(params)
        played = read_tasks(tasks)
        options = EnvironmentOptions(variant, map_file, agents, numbers, played, split, problem)
        return command(options=options, **others)

    param_option = click.option(
        "--param",
        "params",
        multiple=True,
        metavar="NAME=VALUE",
        help="A number of the game: apple=2, regrow[red]=0.1.",
    )
    problem_option = click.option(
        "--problem",
        type=click.IntRange(0, MAX_PROBLEM),
        metavar="N",
        help="Play one task, which number N gives; --seed draws all else.",
    )
    split_option = click.option(
        "--split", metavar="NAME", help="Which tasks are held out, if the game has several splits."
    )
    tasks_option = click.option(
        "--tasks",
        multiple=True,
        metavar="SIDE|FIELD=VALUE",
        help="The tasks to play: training, held_out, all, or fields of them: hue=red, pay[red]=3.",
    )
    of_tasks = tasks_option(split_option(problem_option(with_options)))
    return variant_option(map_option(agents_option(param_option(of_tasks))))


def read_tasks(texts: tuple[str, ...]) -> Tasks | None:
    """Returns the argument `tasks` of `sjdsl.make` from the texts of --tasks."""
    if not texts:
        return None
    sides = [text.strip() for text in texts if "=" not in text]
    if not sides:
        return read_assignments(texts)
    if len(texts) > 1:
        raise click.UsageError(
            "--tasks is one side (training, held_out, all), or fields with values: "
            f"not {', '.join(texts)}"
        )
    return sides[0]


def written_options(*allowed: str) -> list[str]:
    """Returns the options and arguments on the command line, as a user writes them.

    The parameters in `allowed`, by their Python names, are left out.
    """
    context = click.get_current_context()
    written = []
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in allowed or source is not click.core.ParameterSource.COMMANDLINE:
            continue
        if isinstance(parameter, click.Option):
            written.append(max(parameter.opts, key=len))
        else:
            written.append(parameter.make_metavar(context).strip("[]"))
    return written


def read_texts(assignments: tuple[str, ...]) -> dict[str, str]:
    """Returns `name=value` as a mapping of texts."""
    values: dict[str, str] = {}
    for text in assignments:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name:
            raise click.UsageError(f"`{text}` must have the form name=value")
        if name in values:
            _refuse_second(name)
        values[name] = value
    return values


def read_assignments(assignments: tuple[str, ...]) -> dict[str, Any]:
    """Returns `name=value` and `name[index]=value` as a mapping; values are JSON, or text.

    A name with indices has a mapping of them, nested in the order of the brackets.
    """
    values: dict[str, Any] = {}
    for path, value in read_texts(assignments).items():
        *outer, last = (name.strip() for name in path.replace("]", "").split("["))
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
    arguments: Mapping[str, Any], observation: "Encoding" = "tokens"
) -> "Environment":
    """Returns the environment that `EnvironmentOptions.describe` describes.

    Raises CompileError, and ClickException for arguments that don't fit the game.
    """
    try:
        return sjdsl.make(**arguments, observation=observation)
    except (ValueError, TypeError, FileNotFoundError) as error:
        raise click.ClickException(str(error)) from error


@contextmanager
def without_quoting_game(file: Path | str) -> Iterator[None]:
    """Turns faults of a game that a file names into a ClickException without any text of the game.

    The file (a recording, a run) may come from a stranger, and name any text on this machine as its
    game: a message that quotes it would give it away.
    """
    try:
        yield
    except CompileError as error:
        errors = [d for d in error.diagnostics if d.severity == "error"]
        titles = ", ".join(dict.fromkeys(map(_without_text, errors)))
        raise click.ClickException(
            f"{file} names a game, or a map for it, with errors: {titles}; "
            "run `sjdsl check` on them to see where"
        ) from None
    except (ValueError, TypeError, KeyError, OverflowError, OSError) as error:
        raise click.ClickException(
            f"{file} names a game that can't be built with its settings: {error}"
        ) from None


def _without_text(fault: Diagnostic) -> str:
    """Returns the code and title of a fault; the message too if it quotes only the name of a
    file.
    """
    title = f"{fault.code} {fault.title}"
    return f"{title}: {fault.message}" if fault.code == "SJ111" else title
