"""`sjdsl schelling`: what cooperators and defectors earn among each other, and whether that is a dilemma."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.experiments import echo_files, experiment, experiment_options, in_columns, with_bounds
from sjdsl.cli.policies import NAMES

if TYPE_CHECKING:
    from sjdsl.experiments import Diagram

FILES = ("schelling.json", "schelling.png", "schelling.svg")


@click.command("schelling")
@click.argument("game")
@click.option("--cooperators", required=True, metavar="P", help=f"The policy of who cooperates: {NAMES}")
@click.option("--defectors", required=True, metavar="P", help="The policy of who defects, named likewise.")
@experiment_options
def command(game: str, cooperators: str, defectors: str, episodes: int, seed: int, output: str | None, **described: Any) -> None:
    """Plays GAME with k cooperators and N - k defectors, for k = 0 .. N, and says whether it is a dilemma to them.

    An episode begins alike for every k, with the same order of slots, of which the first k cooperate. The folder RUN of several seeds is a
    pool: seed i of one plays with seed i of the other, and the intervals are over seeds. The verdict holds at 95 %.
    """
    folder = Path(output or f"{Path(game).stem}_schelling")
    with experiment(game, (cooperators, defectors), folder, described) as (env, say):
        from sjdsl.experiments import schelling_diagram

        found = schelling_diagram(env, cooperators, defectors, episodes=episodes, seed=seed, folder=folder, tell=say)
    click.echo(_told(found))
    echo_files(folder, FILES)


def _told(found: "Diagram") -> str:
    """Returns the diagram as text: both lines, the contrasts, the verdict, and what was published."""
    from sjdsl.experiments.contrasts import IN_WORDS
    from sjdsl.experiments.published import published_shape

    env, (cooperators, defectors) = found.experiment.env, found.experiment.pools
    lines = [("others who cooperate", "C: cooperating", "D: defecting", "D - C", "preferred")]
    for others, (c, d, (difference, preferred)) in enumerate(zip(found.cooperating, found.defecting, found.preferences, strict=True)):
        lines.append((str(others), with_bounds(c), with_bounds(d), with_bounds(difference), preferred))
    contrasts = [(name, with_bounds(figure), IN_WORDS[name]) for name, figure in found.contrasts.items()]
    published = published_shape(env.name)
    parts = [
        f"\n{env.title or env.name}: cooperators {cooperators.name}, defectors {defectors.name}; {found.population}",
        f"mean return of an agent, with 95 % intervals\n{in_columns(lines)}",
        f"contrasts, with intervals that hold at 95 % together\n{in_columns(contrasts)}",
        f"verdict: {_verdict(found)}",
    ]
    if published is not None:
        note = f" ({published['note']})" if published["note"] else ""
        parts.append(f"published: {published['shape']}, called a {published['type']}{note}; {published['source']}")
    return "\n\n".join(parts)


def _verdict(found: "Diagram") -> str:
    verdict, unit = found.verdict, found.returns.unit
    match verdict.outcome:
        case "dilemma":
            return f"dilemma, {verdict.shape}: {verdict.reason}"
        case "no dilemma":
            return f"no dilemma: {verdict.reason}"
    if found.units < 2:
        return f"undecided: one {unit} has no spread; play two at least"
    wanted = f"about {verdict.wanted:,} {unit}s" if verdict.wanted else f"no number of {unit}s"
    return f"undecided: {verdict.reason}; {wanted} would probably settle it, and there are {found.units:,}"
