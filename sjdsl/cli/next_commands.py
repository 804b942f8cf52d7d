"""The commands that a user may want next, as the last lines of a command."""

import shlex
from collections.abc import Iterable

import click

from sjdsl.cli.list import align


def echo_next(*commands: tuple[str, str]) -> None:
    """Prints commands, each with its purpose."""
    rows = [(f"  {command}", purpose) for command, purpose in commands]
    click.echo("\n".join(align([("next:", ""), *rows])))


def allowing(names: Iterable[str]) -> str:
    """Returns the options that allow a user's own code, as text for a command line."""
    return "".join(f" --allow-code {shlex.quote(name)}" for name in names)


def repeated_options(*names: str) -> str:
    """Returns options of this command line again, as text for another: ` --variant rich`.

    Args:
      names: of the parameters, in Python; those that the user hasn't written are left out.
    """
    context = click.get_current_context()
    text = ""
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if name not in names or source is not click.core.ParameterSource.COMMANDLINE:
            continue
        values = context.params[name] if parameter.multiple else [context.params[name]]
        for value in values:
            text += f" {max(parameter.opts, key=len)} {shlex.quote(str(value))}"
    return text
