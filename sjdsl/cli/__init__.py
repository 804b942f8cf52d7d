"""The command `sjdsl`: one module for each subcommand.

A module is imported when its command is called, so that `check` never waits for JAX.
"""

import ast
import gc
import inspect
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType
from typing import NoReturn

import click

from sjdsl.cli.encoding import accept_any_text
from sjdsl.cli.examples import epilog
from sjdsl.cli.faults import INTERRUPTED, report_fault
from sjdsl.cli.pointer import pointing_to_explanations
from sjdsl.library.cache import keep_programs
from sjdsl.near_names import meant
from sjdsl.termination import TERMINATED, Terminated, raising_on_sigterm

GROUPS = {
    "Write a game": {
        "new": "Create a new game: a file, a map and a test.",
        "check": "Report all mistakes in a game.",
        "fmt": "Format the text of games.",
        "explain": "Explain the code of a message, such as SJ101.",
        "compile": "Write a game as a Python module.",
        "dump": "Show a game after one stage of the compiler.",
    },
    "Look at it": {
        "list": "List games with their agents, maps, actions, titles and variants.",
        "doc": "Print all the rules of a game on a page.",
        "diff": "Print what differs between two variants or games.",
        "play": "Control an agent of a game in the terminal.",
        "render": "Draw a game as a GIF, MP4, PNG or HTML page.",
        "trace": "Print what happens in a game, rule by rule and draw by draw.",
        "record": "Store whole episodes as arrays.",
        "replay": "Show a recorded episode.",
    },
    "Test it": {
        "test": "Test the checks of a game.",
        "bench": "Measure how fast games run.",
    },
    "Train agents": {
        "train": "Train agents in a game.",
        "evaluate": "Evaluate a trained policy, compared with a random one.",
        "plot": "Plot learning curves of runs.",
    },
    "Experiment": {
        "sweep": "Train over a grid of configurations and games.",
        "crossplay": "Play policies with each other, mixture by mixture.",
        "schelling": "Plot what cooperators and defectors earn, and test for a dilemma.",
        "report": "Make tables and pictures of results.",
    },
    "Serve": {
        "studio": "Write and play a game in the browser.",
        "lsp": "Serve editors over the Language Server Protocol.",
    },
}
COMMANDS = {name: summary for group in GROUPS.values() for name, summary in group.items()}

# Allocations between two garbage collections. Most of what a command allocates at first (modules,
# classes, tables) lives until the process ends: collecting garbage takes a fifth of the time of
# `check`.
COLLECTION_THRESHOLD = 1_000_000


class Commands(click.Group):
    """The subcommands, each imported when first used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return [*COMMANDS]  # `list` here is the subcommand, once it is imported

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Returns a command, whose module is imported only now."""
        del ctx
        if cmd_name not in COMMANDS:
            return None
        module = import_module(f"sjdsl.cli.{cmd_name}")
        command: click.Command = module.command
        if command.help is None:  # `python -OO` leaves out docstrings
            command.help = _docstring_in_source(module)
        command.epilog = epilog(cmd_name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Lists the commands without importing them."""
        del ctx
        for title, group in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([*group.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Names the nearest command for one that doesn't exist."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(
                f"there is no command `{args[0]}`{meant(args[0], COMMANDS, 'the commands are')}"
            )
        return super().resolve_command(ctx, args)


def _docstring_in_source(module: ModuleType) -> str | None:
    """Returns the docstring of `command` in the source of a module."""
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.FunctionDef) and node.name == "command":
            return ast.get_docstring(node)
    return None


@click.group(
    cls=Commands,
    invoke_without_command=True,
    subcommand_metavar="COMMAND [ARGS]...",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="sjdsl", message="sjdsl %(version)s")
@click.pass_context
def commands(context: click.Context) -> None:
    """Compiles social-dilemma games written in `.sj` files into JAX environments, and trains agents
    in them."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def run(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit status.

    The status is 0 if it succeeds, 1 for a fault in the game or files, and 2 for a wrong call.
    """
    if arguments is None:
        arguments = sys.argv[1:]
    with pointing_to_explanations():
        try:
            result = commands.main(arguments, prog_name="sjdsl", standalone_mode=False)
        except click.exceptions.Exit as exit_:
            return exit_.exit_code
        except Exception as error:
            name = next((argument for argument in arguments if argument in COMMANDS), None)
            return report_fault(error, "sjdsl" if name is None else f"sjdsl {name}")
    return result if isinstance(result, int) else 0


def main() -> NoReturn:
    """Runs the command line of this process; programs that JAX compiles are cached for the next."""
    gc.set_threshold(COLLECTION_THRESHOLD)
    # NumPy would spend a tenth of a second on starting threads that no command uses.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # To look for plugins, pydantic would read the metadata of every installed package.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    accept_any_text()
    keep_programs()
    try:
        with raising_on_sigterm():
            status = run()
            sys.stdout.flush()
    except Terminated:
        status = TERMINATED
    except KeyboardInterrupt:  # before or after the command itself
        status = INTERRUPTED
    except BrokenPipeError:  # the reader has closed the pipe, as `head` does; discard the rest
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 1
    gc.freeze()
    if status in (INTERRUPTED, TERMINATED):
        # XLA may still be compiling: it can't be stopped, and would crash when Python exits.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)
