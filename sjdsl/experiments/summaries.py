"""The results of experiments as text for a terminal."""

import math
from collections.abc import Sequence

from sjdsl.experiments.contrasts import IN_WORDS
from sjdsl.experiments.diagram import Diagram
from sjdsl.experiments.mixtures import CrossPlay
from sjdsl.experiments.scenario_scores import RANDOM, ScenarioScores
from sjdsl.trainers.policies.estimates import Estimate


def diagram_text(found: Diagram) -> str:
    """Returns the diagram as text: both lines, the contrasts and the verdict."""
    cooperators, defectors = found.experiment.pools
    lines = [("others who cooperate", "C: cooperating", "D: defecting", "D - C", "preferred")]
    for others, (c, d, (difference, preferred)) in enumerate(
        zip(found.cooperating, found.defecting, found.preferences, strict=True)
    ):
        lines.append(
            (str(others), _with_bounds(c), _with_bounds(d), _with_bounds(difference), preferred)
        )
    contrasts = [
        (name, _with_bounds(figure), IN_WORDS[name]) for name, figure in found.contrasts.items()
    ]
    parts = [
        f"\n{found.experiment.title}: cooperators {cooperators.name}, defectors {defectors.name}; {found.population}",
        f"mean return of an agent, with 95 % intervals\n{_in_columns(lines)}",
        f"contrasts, with intervals that hold at 95 % together\n{_in_columns(contrasts)}",
        "\n".join(filter(None, (f"verdict: {_verdict(found)}", found.caution))),
    ]
    return "\n\n".join(parts)


def _verdict(found: Diagram) -> str:
    verdict, unit = found.verdict, found.returns.unit
    match verdict.outcome:
        case "dilemma":
            return f"dilemma, {verdict.shape}: {verdict.reason}"
        case "no dilemma":
            return f"no dilemma: {verdict.reason}"
    if found.units < 2:
        return f"undecided: one {unit} has no spread; play at least two"
    wanted = (
        f"about {verdict.wanted:,} {unit}s" if verdict.wanted else f"no feasible number of {unit}s"
    )
    return f"undecided: {verdict.reason}; {wanted} would probably settle it, and there are {found.units:,}"


def crossplay_text(found: CrossPlay) -> str:
    """Returns the return of each policy in each mixture, as text, and which policies the short names in it stand for."""
    experiment, names = found.experiment, found.short_names
    rows = [("mixture", "policy", "return of an agent")]
    for lineup in experiment.lineups:
        for number, figure in found.estimates(lineup).items():
            rows.append((found.mixture(lineup, names), names[number], _with_bounds(figure)))
    over = (
        f"{experiment.replicates} training seeds"
        if experiment.replicates > 1
        else f"{experiment.episodes} episodes, of these policies only"
    )
    if len({found.unit_of(lineup) for lineup in experiment.lineups}) > 1:
        over += f"; of mixtures without a trained policy over {experiment.episodes * experiment.replicates} episodes"
    table = f"\n{experiment.title}: means with 95 % intervals over {over}\n{_in_columns(rows)}"
    shortened = [
        (short, name) for short, name in zip(names, found.names, strict=True) if short != name
    ]
    return f"{table}\n\nthe policies\n{_in_columns(shortened)}" if shortened else table


def scenarios_text(found: ScenarioScores) -> str:
    """Returns the returns and scores of the focal policy in each requested scenario, as text."""
    agents = found.experiment.env.num_agents
    rows = [
        (
            "scenario",
            "focal agents",
            "focal return",
            "background return",
            "random",
            "best scripted",
            "score",
        )
    ]
    cautions = []
    for name in found.scenarios:
        score = found[name]
        background = "none" if score.background is None else _with_bounds(score.background)
        best = f"{score.baseline(score.best).mean:.4g}, {score.best}"
        shown = "undefined" if score.score is None else f"{score.score:.3g}"
        random = f"{score.baseline(RANDOM).mean:.4g}"
        rows.append(
            (
                name,
                f"{score.number_focal} of {agents}",
                _with_bounds(score.focal),
                background,
                random,
                best,
                shown,
            )
        )
        cautions += [f"{name}: {score.caution}"] if score.caution else []
    head = f"\n{found.experiment.title}: focal agents play {found.policy}; mean returns of an agent, with 95 % intervals over {found.population}"
    said = "score: (focal - random) / (best scripted - random), where random and best scripted play the focal agents of the same scenario"
    return "\n".join([head, _in_columns(rows), said, *cautions])


def _in_columns(rows: Sequence[Sequence[str]]) -> str:
    """Returns rows of cells as lines, each column as wide as its widest cell."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return "\n".join(
        "  "
        + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _with_bounds(figure: Estimate) -> str:
    """Returns `97.3 [95.1, 99.4]`; a single sample has no bounds."""
    if not math.isfinite(figure.low):
        return f"{figure.mean:.4g} [not known]"
    return f"{figure.mean:.4g} [{figure.low:.4g}, {figure.high:.4g}]"
