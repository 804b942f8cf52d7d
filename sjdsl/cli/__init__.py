"""The command `sjdsl`: one module a subcommand, imported when it is called, so that `check` never waits for JAX."""

import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

import click

from sjdsl.cache import keep_programs
from sjdsl.cli.examples import below
from sjdsl.cli.faults import report_fault
from sjdsl.cli.pointer import pointed
from sjdsl.cli.terminal import INTERRUPTED, leave_at_once_if_compiling
from sjdsl.near_names import meant

COMMANDS = {
    "bench": "Measure how fast games run.",
    "check": "Report all mistakes in a game.",
    "compile": "Write a game as a Python module.",
    "crossplay": "Play policies with each other, mixture by mixture.",
    "diff": "Print what differs between two variants or games.",
    "doc": "Print the rules of a game in plain English.",
    "dump": "Show a game after one stage of the compiler.",
    "evaluate": "Evaluate a trained policy, compared with a random one.",
    "explain": "Explain the code of a message, such as SJ101.",
    "fmt": "Format the text of games.",
    "list": "List games: agents, actions, parameters, variants.",
    "lsp": "Serve editors: messages, completion, names, over the Language Server Protocol.",
    "new": "Create a new game: a file, a map and a test.",
    "play": "Control an agent of a game in the terminal.",
    "plot": "Plot learning curves of runs.",
    "record": "Store whole episodes as arrays: observations, actions, rewards.",
    "render": "Draw a game as a GIF, MP4 or PNG.",
    "replay": "Show a recorded episode.",
    "report": "Make tables and pictures of results.",
    "schelling": "Plot what cooperators and defectors earn, and test for a dilemma.",
    "studio": "Write and play a game in the browser.",
    "sweep": "Train in a grid of configurations and games.",
    "test": "Test the checks of a game.",
    "trace": "Print what happens in a game, rule by rule and draw by draw.",
    "train": "Train agents in a game.",
}

# Nearly all that a command makes at first (modules, classes, tables) stays: looking for garbage in it, again when the process
# ends, takes a fifth of the time of `check`.
FEW_COLLECTIONS = 1_000_000


class Commands(click.Group):
    """The subcommands, each imported when first asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return [*COMMANDS]  # `list` here is the subcommand, once it is imported

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        del ctx
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"sjdsl.cli.{cmd_name}").command
        command.epilog = below(cmd_name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Lists the commands without importing them."""
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl([*COMMANDS.items()])

    def resolve_command(self, ctx: click.Context, args: list[str]) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(f"there is no command `{args[0]}`{meant(args[0], COMMANDS, 'the commands are')}", ctx)
        return super().resolve_command(ctx, args)


@click.group(
    cls=Commands,
    invoke_without_command=True,
    subcommand_metavar="COMMAND [ARGS]...",
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="sjdsl", message="sjdsl %(version)s")
@click.pass_context
def commands(context: click.Context) -> None:
    """Compiles social-dilemma games written in `.sj` files into JAX environments, and trains agents in them."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def run(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; returns the exit status: 0 done, 1 something is wrong with the game or files, 2 with the call."""
    with pointed():
        try:
            result = commands.main(arguments, prog_name="sjdsl", standalone_mode=False)
        except click.exceptions.Exit as exit_:
            return exit_.exit_code
        except Exception as error:
            return report_fault(error)
    return result if isinstance(result, int) else 0


def main() -> NoReturn:
    """Runs the command line of this process; what JAX compiles in it is kept for the next."""
    gc.set_threshold(FEW_COLLECTIONS)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # NumPy would start threads that no command uses: a tenth of a second
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # looking for plugins reads what every installed package says of itself
    keep_programs()
    try:
        status = run()
        sys.stdout.flush()
    except KeyboardInterrupt:  # before or after the command itself
        status = INTERRUPTED
    except BrokenPipeError:  # whoever reads has enough, as `head` has; what is left is written to nobody
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 1
    gc.freeze()
    leave_at_once_if_compiling(status)
    sys.exit(status)
