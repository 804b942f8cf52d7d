"""`sjdsl explain`: prints the long explanation of an error code."""

import click


@click.command("explain")
@click.argument("code")
def command(code: str) -> None:
    """Explains the message with this CODE, such as SJ101: what it means, an example, how to repair
    it.
    """
    from sjdsl.compiler.diagnostics.explanations import explain

    try:
        click.echo(explain(code))
    except (KeyError, ValueError) as error:
        raise click.ClickException(str(error.args[0])) from None
