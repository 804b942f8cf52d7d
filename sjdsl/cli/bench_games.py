"""Selects what `sjdsl bench` measures: games, numbers of agents, observations."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from sjdsl.cli.environment_options import describe_environment, make_environment
from sjdsl.compiler.diagnostics.diagnostic import CompileError

if TYPE_CHECKING:
    from sjdsl.bench import Task
    from sjdsl.runtime.env import Encoding

CROWD = "crowd"  # the variant with room for many agents, where the game itself has too little


def choose_tasks(
    games: Sequence[str], variant: str | None, observations: "Sequence[Encoding]", agents: Sequence[int | None]
) -> tuple[list["Task"], list[str]]:
    """Returns what is to be measured, and a line for each form that its game refuses.

    Args:
      games: names or files.
      variant: of all of them.
      observations: `tokens`, `onehot` or both.
      agents: numbers of agents; None is the game's own.
    Raises CompileError, ClickException: a game that cannot be compiled as it is, or no form that is accepted.
    """
    tasks: list[Task] = []
    refused: list[str] = []
    for game in games:
        make_environment(describe_environment(game, variant, None, None, {}))  # what is wrong with the game is no refusal of a number
        for number in agents:
            try:
                tasks += _tasks_of(game, variant, number, observations)
            except CompileError as error:
                said = "; ".join(mistake.message for mistake in error.diagnostics)
                refused.append(f"{game} is left out with {number} agents: {said}")
    if not tasks:
        raise click.ClickException("; ".join(refused))
    return tasks, refused


def _tasks_of(game: str, variant: str | None, number: int | None, observations: "Sequence[Encoding]") -> Iterator["Task"]:
    """Yields a game by observation; with a number of agents it has no room for, its crowd. Raises the refusal of the game itself."""
    from sjdsl.bench import game_task

    form = describe_environment(game, variant, None, number, {})
    try:
        make_environment(form)
    except CompileError as refusal:
        form["variant"] = f"{variant}+{CROWD}" if variant else CROWD
        try:
            make_environment(form)
        except CompileError:
            raise refusal from None
    for observation in observations:
        env = make_environment(form, observation)
        yield game_task(env, f"{env.name}+{form['variant']}" if form["variant"] else env.name, number)
