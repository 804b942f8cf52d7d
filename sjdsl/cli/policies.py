"""Finds policies by the names that commands accept: `random`, `stay`, a run, a stored policy, a
Python function."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from sjdsl.models import find_model, is_model_name
from sjdsl.models.roles import wordings
from sjdsl.trainers.settings.extensions import allow_code
from sjdsl.trainers.settings.policy_names import (
    YOU,
    might_be_named,
    seat_of_person,
    unknown_policy,
)

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Environment

NAMES = (
    "random, stay, a policy of the game's file, RUN, RUN@best, RUN@UPDATE, FILE.safetensors, "
    "FILE.py:FUNCTION, or a language model, models.toml:NAME or models.toml:NAME+ROLE."
)
SIDE_BY_SIDE = "file"
FROM_FILE = (
    "agent 0 follows the first policy of the game's file, agent 1 the second, and so on; random "
    "agents if it has none"
)
policy_option = click.option(
    "--policy",
    default=SIDE_BY_SIDE,
    show_default=True,
    metavar="P",
    help=f"Who plays. {SIDE_BY_SIDE}: {FROM_FILE}. Or one policy for all agents: {NAMES}",
)


def _allow_code(_: click.Context, __: click.Parameter, names: tuple[str, ...]) -> None:
    """Lets stored policies and runs load the code that --allow-code names."""
    try:
        allow_code(*names)
    except ValueError as error:
        raise click.UsageError(str(error)) from None


code_option = click.option(
    "--allow-code",
    multiple=True,
    metavar="FILE.py:NAME",
    expose_value=False,
    callback=_allow_code,
    help="Your own code that a stored policy or run may load.",
)


def check_policy(name: str, game: "ir.Game") -> None:
    """Raises ClickException for a text that can't name a policy of the game, and ModelError for a
    wrong file of models; needs no JAX.
    """
    declared = [policy.name for policy in game.policies]
    if is_model_name(name):
        wordings(find_model(name).role, game)  # raises
        return
    if name != SIDE_BY_SIDE and not might_be_named(name, declared):
        raise click.ClickException(unknown_policy(name, declared))


def read_seats(slots: str, game: "ir.Game") -> tuple[list[str], int | None]:
    """Returns the names of --slots, and the agent that a person plays, if any.

    `file` becomes the name of the agent's policy in the game's file, or `random`.

    Raises ClickException for names that don't fit the game, and ModelError for a wrong file of
    models; needs no JAX.
    """
    declared = [policy.name for policy in game.policies] or ["random"]
    seats = [
        declared[agent % len(declared)] if name.strip() == SIDE_BY_SIDE else name.strip()
        for agent, name in enumerate(slots.split(","))
    ]
    try:
        person = seat_of_person(seats, game.agents.number, game.name)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    for name in seats:
        if name != YOU:
            check_policy(name, game)
    return seats, person


def players_of(name: str, game: "ir.Game") -> list[str]:
    """Returns the name of the policy that each agent follows if `name` is that of --policy."""
    names = [name]
    if name == SIDE_BY_SIDE:
        names = [policy.name for policy in game.policies] or ["random"]
    return [names[agent % len(names)] for agent in range(game.agents.number)]


def choose_policy(name: str, env: "Environment") -> Any:
    """Returns a policy by its name, unless it is asked in words; warnings about it are printed as
    notes.
    """
    from sjdsl.runtime.policy import UNTRAINED, mixed_policy

    if name == SIDE_BY_SIDE:
        policies = [choose_policy(policy.name, env) for policy in env.game.policies]
        if not policies:
            return UNTRAINED["random"](env)
        assignments = [
            (range(first, env.num_agents, len(policies)), policy)
            for first, policy in enumerate(policies)
        ]
        return mixed_policy(env.num_agents, assignments)
    if name in UNTRAINED:  # they need no trainers, whose packages take a second to load
        return UNTRAINED[name](env)
    check_policy(name, env.game)
    from sjdsl.trainers import find_policy

    with warnings_as_notes():
        return find_policy(name, env)


@contextmanager
def warnings_as_notes() -> Iterator[None]:
    """Prints each warning as a line that begins with `note:`."""
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        try:
            yield
        finally:
            for note in notes:
                click.echo(f"note: {note.message}", err=True)
