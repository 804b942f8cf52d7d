"""Turns exceptions into messages: one line or a diagnostic for a user's mistake, a traceback for a
bug of ours.
"""

import sys

import click

from sjdsl.extras import MissingExtra
from sjdsl.printable import printable
from sjdsl.termination import TERMINATED, Terminated

INTERRUPTED = 130  # the exit status of a command that Ctrl-C ended
FAULTS_OF_RUNS = {
    "sjdsl.trainers.settings.config_errors": "ConfigError",
    "sjdsl.trainers.policies.policy_file": "PolicyError",
    "sjdsl.trainers.runs.run_errors": "RunError",
    "sjdsl.models.errors": "ModelError",
    "sjdsl.experiments.refusals": "ExperimentError",
    "sjdsl.results.refusals": "ResultsError",
}


def report_fault(error: Exception, command: str) -> int:
    """Prints what went wrong and returns the exit status; re-raises an error that isn't the user's.

    Args:
      command: its help is what a usage error points to.
    """
    match error:
        case click.Abort():
            click.echo("interrupted", err=True)
            return TERMINATED if isinstance(error.__cause__, Terminated) else INTERRUPTED
        case click.UsageError():
            _echo(error.format_message())
            click.echo(f"see `{command} --help`", err=True)
            return error.exit_code
        case click.ClickException():
            _echo(error.format_message())
            return error.exit_code
        case MissingExtra():
            _echo(str(error))
            return 1
        case OSError() if error.filename is not None:
            _echo(f"{error.filename}: {(error.strerror or 'cannot be used').lower()}")
            return 1
    for module_name, class_name in FAULTS_OF_RUNS.items():
        module = sys.modules.get(module_name)  # a module that isn't imported has raised nothing
        if module is not None and isinstance(error, getattr(module, class_name)):
            _echo(str(error))
            return getattr(error, "exit_status", 1)
    from sjdsl.compiler.diagnostics.diagnostic import CompileError

    if isinstance(error, CompileError):
        from sjdsl.cli.diagnostics import print_diagnostics

        print_diagnostics(error.diagnostics, err=True)
        return 1
    raise error


def _echo(message: str) -> None:
    """Prints a message, which may quote a file."""
    click.echo(f"error: {printable(message, lines=True)}", err=True)
