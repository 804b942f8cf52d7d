"""Turns exceptions into messages: one line or a diagnostic for a user's mistake, a traceback for a bug of ours."""

import sys

import click

from sjdsl.cli.terminal import INTERRUPTED
from sjdsl.extras import MissingExtra


def report_fault(error: Exception, called: str) -> int:
    """Prints what went wrong and returns the exit status; raises again what isn't a mistake of the user.

    Args:
      called: the command, whose help is pointed to where it was called in a wrong way.
    """
    match error:
        case click.Abort():
            click.echo("interrupted", err=True)
            return INTERRUPTED
        case click.UsageError():
            click.echo(f"error: {error.format_message()}", err=True)
            click.echo(f"see `{called} --help`", err=True)
            return error.exit_code
        case click.ClickException():
            click.echo(f"error: {error.format_message()}", err=True)
            return error.exit_code
        case MissingExtra():
            click.echo(f"error: {error}", err=True)
            return 1
        case OSError() if error.filename is not None:
            click.echo(f"error: {error.filename}: {(error.strerror or 'cannot be used').lower()}", err=True)
            return 1
    if _is_fault_of_a_run(error):
        click.echo(f"error: {error}", err=True)
        return 1
    from sjdsl.compiler.diagnostics.diagnostic import CompileError

    if isinstance(error, CompileError):
        from sjdsl.cli.diagnostics import print_diagnostics

        print_diagnostics(error.diagnostics, err=True)
        return 1
    raise error


FAULTS_OF_RUNS = {
    "sjdsl.trainers.config_errors": "ConfigError",
    "sjdsl.trainers.policy_file": "PolicyError",
    "sjdsl.trainers.run_errors": "RunError",
    "sjdsl.experiments.refusals": "ExperimentError",
    "sjdsl.results.refusals": "ResultsError",
}


def _is_fault_of_a_run(error: Exception) -> bool:
    """Returns whether a trainer or an experiment refuses what it was given; such an error exists only once the module that has it is imported."""
    modules = {name: sys.modules.get(module) for module, name in FAULTS_OF_RUNS.items()}
    return any(module is not None and isinstance(error, getattr(module, name)) for name, module in modules.items())
