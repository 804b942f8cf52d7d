"""`sjdsl crossplay`: what policies earn when they play with each other."""

from pathlib import Path
from typing import Literal

import click

from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.cli.experiment_options import echo_files, experiment_options, prepare_experiment
from sjdsl.cli.model_options import Asking, show_forecast
from sjdsl.cli.policies import NAMES, warnings_as_notes
from sjdsl.extras import require

FILES = ("crossplay.csv", "crossplay.json", "matrix.png")


class SeveralPolicies(click.Command):
    """A command whose `--policies` takes all words up to the next option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Lets `--policies` take several policies: it is repeated before each."""
        repeated: list[str] = []  # the arguments with `--policies` before each policy
        is_policy = False
        for argument in args:
            if argument == "--policies":
                is_policy = True
                continue
            if argument.startswith("-"):
                is_policy = False
            if is_policy:
                repeated.append("--policies")
            repeated.append(argument)
        if args[-1:] == ["--policies"]:
            repeated.append("--policies")  # click complains about the missing value
        return super().parse_args(ctx, repeated)


@click.command("crossplay", cls=SeveralPolicies)
@click.argument("game")
@click.option(
    "--slots", metavar="P,P,...", help="A policy for each slot, in order: one fixed line-up."
)
@click.option(
    "--policies",
    multiple=True,
    metavar="P P ...",
    help=f"Play the mixtures of these policies: {NAMES}",
)
@click.option(
    "--mix",
    type=click.Choice(["all", "pairs"]),
    help="All mixtures (the default), or one agent among others of another policy.",
)
@click.option(
    "--rotate", is_flag=True, help="With --slots: they move on by one slot with each episode."
)
@experiment_options
def command(
    game: str,
    slots: str | None,
    policies: tuple[str, ...],
    mix: Literal["all", "pairs"] | None,
    rotate: bool,
    episodes: int,
    seed: int,
    output: str | None,
    options: EnvironmentOptions,
    asking: Asking,
) -> None:
    """Plays policies with each other in GAME: in one line-up, or in all mixtures of them.

    Each episode of a mixture draws which policy gets which slot. A RUN of several seeds is a pool:
    seed i of one plays with seed i of the others, and the intervals are over seeds.
    """
    has_both = slots is not None and bool(policies)
    if has_both or (slots is None and not policies):
        raise click.UsageError(
            "give either --slots, a policy for each slot, or --policies, whose mixtures are played"
        )
    if slots is not None and mix is not None:
        raise click.UsageError("--mix is for --policies; --slots is one line-up")
    if slots is None and rotate:
        raise click.UsageError("--rotate is for --slots; mixtures draw who has which slot")
    in_slots = None if slots is None else [name.strip() for name in slots.split(",")]
    if "" in (in_slots or policies):
        raise click.UsageError(
            "a policy has no name; write one between commas, as in --slots cooperator,random"
        )
    require("plots", "matplotlib")
    folder = Path(output or f"{Path(game).stem}_crossplay")
    with prepare_experiment(game, in_slots or policies, folder, options) as (env, say):
        from sjdsl.experiments.crossplay import (
            describe_cross_play,
            plan_cross_play,
            play_mixtures,
        )
        from sjdsl.experiments.summaries import crossplay_text

        kind = mix or "all"
        with warnings_as_notes():
            plan = plan_cross_play(env, in_slots, policies or None, kind, episodes, seed, rotate)
        mixed = kind if in_slots is None else None
        show_forecast(plan, asking, folder, describe_cross_play(plan, mixed))
        results = play_mixtures(plan, mixed, folder, say, asking.limits)
    click.echo(crossplay_text(results))
    echo_files(folder, FILES)
