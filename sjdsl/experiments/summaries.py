"""The results of experiments as text for a terminal."""

from collections.abc import Sequence

from sjdsl.experiments.contrasts import IN_WORDS
from sjdsl.experiments.diagram import Diagram
from sjdsl.experiments.mixtures import CrossPlay
from sjdsl.experiments.scenario_scores import RANDOM, ScenarioScores
from sjdsl.experiments.usage import too_many_invalid, usage_text


def diagram_text(diagram: Diagram) -> str:
    """Returns the diagram as text: both lines, the contrasts and the verdict."""
    cooperators, defectors = diagram.experiment.pools
    lines: list[tuple[str, ...]] = [
        ("others who cooperate", "C: cooperating", "D: defecting", "D - C", "preferred")
    ]
    cooperating = diagram.cooperating
    defecting = diagram.defecting
    for others, (difference, preferred) in enumerate(diagram.preferences):
        figures = (cooperating[others], defecting[others], difference)
        lines.append((str(others), *map(str, figures), preferred))
    contrasts = [(name, str(figure), IN_WORDS[name]) for name, figure in diagram.contrasts.items()]
    parts = [
        f"\n{diagram.experiment.title}: cooperators {cooperators.name}, "
        f"defectors {defectors.name}; {diagram.population}",
        f"mean return of an agent, with 95 % intervals\n{in_columns(lines)}",
        f"contrasts, with intervals that hold at 95 % together\n{in_columns(contrasts)}",
        f"verdict: {_verdict_text(diagram)}",
    ]
    text = "\n\n".join(parts)
    if diagram.caution:
        text += f"\n{diagram.caution}"
    return f"{text}\n{usage_text(diagram.usage, diagram.wordings)}".rstrip()


def _verdict_text(diagram: Diagram) -> str:
    """Returns the verdict and its reason; if it is undecided, also how many samples it takes."""
    verdict = diagram.verdict
    unit = diagram.returns.unit
    match verdict.outcome:
        case "dilemma":
            return f"dilemma, {verdict.shape}: {verdict.reason}"
        case "no dilemma":
            return f"no dilemma: {verdict.reason}"
    if too_many_invalid(diagram.usage):
        return f"undecided: {verdict.reason}"
    if diagram.units < 2:
        return f"undecided: one {unit} has no spread; play at least two"
    number = f"about {verdict.wanted:,}" if verdict.wanted else "no feasible number of"
    return (
        f"undecided: {verdict.reason}; {number} {unit}s would probably settle it, "
        f"and there are {diagram.units:,}"
    )


def crossplay_text(results: CrossPlay) -> str:
    """Returns the return of each policy in each mixture, as text, and the full names of the
    policies whose names are shortened in it."""
    experiment = results.experiment
    names = results.short_names
    rows = [("mixture", "policy", "return of an agent")]
    for lineup in experiment.lineups:
        for index, figure in results.estimates(lineup).items():
            rows.append((results.mixture(lineup, names), names[index], str(figure)))
    samples = f"{experiment.episodes} episodes, of these policies only"
    if experiment.replicates > 1:
        samples = f"{experiment.replicates} training seeds"
    if len({results.unit_of(lineup) for lineup in experiment.lineups}) > 1:
        episodes = experiment.episodes * experiment.replicates
        samples += f"; of mixtures without a trained policy over {episodes} episodes"
    table = f"\n{experiment.title}: means with 95 % intervals over {samples}\n{in_columns(rows)}"
    shortened = [
        (short, name) for short, name in zip(names, results.names, strict=True) if short != name
    ]
    if shortened:
        table += f"\n\nthe policies\n{in_columns(shortened)}"
    return f"{table}\n{usage_text(results.usage, results.wordings)}".rstrip()


def scenarios_text(scores: ScenarioScores) -> str:
    """Returns the returns and scores of the focal policy in each requested scenario, as text."""
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
    for name, score in scores.scenarios.items():
        rows.append(
            (
                name,
                f"{score.number_focal} of {scores.experiment.env.num_agents}",
                str(score.focal),
                "none" if score.background is None else str(score.background),
                str(score.baseline(RANDOM)),
                f"{score.baseline(score.best)}, {score.best}",
                "undefined" if score.score is None else f"{score.score:.3g}",
            )
        )
        if score.caution:
            cautions.append(f"{name}: {score.caution}")
    title = (
        f"\n{scores.experiment.title}: focal agents play {scores.policy}; mean returns of an "
        f"agent, with 95 % intervals over {scores.population}"
    )
    definition = (
        "score: (focal - random) / (best scripted - random), where random and best scripted play "
        "the focal agents of the same scenario"
    )
    of_wordings = {
        f"{scores.policy} in {name}": score.by_wording
        for name, score in scores.scenarios.items()
        if score.by_wording
    }
    lines = [title, in_columns(rows), definition, *cautions]
    lines.append(usage_text(scores.usage, of_wordings))
    return "\n".join(lines).rstrip()


def in_columns(rows: Sequence[Sequence[str]]) -> str:
    """Returns rows of cells as lines, each column as wide as its widest cell."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        lines.append(f"  {'  '.join(cells)}".rstrip())
    return "\n".join(lines)
