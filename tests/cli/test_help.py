"""What `--help` says of each command: every option is told in words, its values have a name, and the examples are calls that can be made."""

import shlex

import click
import pytest

from sjdsl.cli import COMMANDS, commands
from sjdsl.cli.examples import EXAMPLES

ABOVE = click.Context(commands, info_name="sjdsl")
WIDTH = 100


def command(name: str) -> click.Command:
    found = commands.get_command(ABOVE, name)
    assert found is not None
    return found


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_told(name: str) -> None:
    for option in command(name).params:
        if isinstance(option, click.Option):
            assert option.help, option.opts
            said = option.help.split("  [default")[0]
            assert said[0].isupper(), said
            assert said.endswith("."), said
            assert "RANGE" not in option.make_metavar(ABOVE), option.opts


@pytest.mark.parametrize("name", COMMANDS)
def test_the_examples_are_calls(name: str) -> None:
    shown = command(name).get_help(
        click.Context(command(name), parent=ABOVE, info_name=name, max_content_width=WIDTH)
    )
    assert len(EXAMPLES[name]) == (1 if name in ("list", "lsp") else 2)  # they take nothing
    for line in EXAMPLES[name]:
        program, called, *arguments = shlex.split(line)
        assert (program, called) == ("sjdsl", name)
        assert f"\n    {line}\n" in shown + "\n", shown
        command(name).make_context(name, arguments, parent=ABOVE)
