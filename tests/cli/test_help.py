"""What `--help` says of each command: every option is told in words, its values have a name, and the examples are calls that can be made."""

import shlex
import subprocess
import sys

import click
import pytest

from sjdsl.cli import COMMANDS, GROUPS, commands
from sjdsl.cli.examples import EXAMPLES

ABOVE = click.Context(commands, info_name="sjdsl")
WIDTH = 100
LINES = 40


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


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_fits_one_screen(name: str) -> None:
    """As it is printed in a terminal of 80 columns."""
    shown = (
        command(name)
        .get_help(click.Context(command(name), parent=ABOVE, info_name=name, terminal_width=80))
        .splitlines()
    )
    assert len(shown) <= LINES, "\n".join(shown)
    assert max(map(len, shown)) <= 80


def test_every_command_has_examples_and_a_group() -> None:
    assert {*EXAMPLES} == {*COMMANDS}
    shown = commands.get_help(click.Context(commands, info_name="sjdsl"))
    assert len(shown.splitlines()) <= LINES + 10
    for title, group in GROUPS.items():
        below = shown.partition(f"\n{title}:\n")[2].partition("\n\n")[0]
        assert [
            line.split()[0]
            for line in below.splitlines()
            if line.startswith("  ") and line[2] != " "
        ] == [*group]


def test_help_without_docstrings() -> None:
    """`python -OO` leaves them out."""
    for name in ("check", "train"):
        ran = subprocess.run(
            [sys.executable, "-OO", "-m", "sjdsl", name, "--help"], capture_output=True, text=True
        )
        assert (command(name).help or "").split(".")[0].split() == ran.stdout.partition("\n\n")[
            2
        ].split(".")[0].split()
