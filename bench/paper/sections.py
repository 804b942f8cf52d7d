"""The sections of docs/results.md that compare our results with the paper's: each is a function of
the results."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import pandas as pd

from bench.paper import published
from bench.paper.contents import (
    COMMON,
    INDIVIDUAL,
    MAPPO,
    PROSOCIAL,
    RATIOS,
    SVO,
    VDN,
    Game,
    Method,
    exchanged,
    sort_key,
)
from bench.paper.ninety_five_percent_rule import RESAMPLES, choice_frequencies, chosen_ratio
from bench.paper.published import PaperMetric, Printed
from bench.paper.small_multiples import Multiple, Series, draw_series
from sjdsl.results import sections
from sjdsl.results.figures import (
    EMPTY,
    Figure,
    Result,
    Table,
    differing_settings,
    interval,
    number,
    result_figure,
)
from sjdsl.results.page import Picture, Section
from sjdsl.results.sections import (
    BEHIND,
    compared_table,
    diagram_rows,
    of_record,
    score_results,
    section_over_games,
)
from sjdsl.results.selecting import APART, SHARED, in_words, result_of, select, setting_of
from sjdsl.results.statistics import compare

TRAINED = "training seed"  # the sampling unit of diagrams of trained pools
OF_COMMON = ("common_reward",)  # a setting that only common reward uses
HOLDS = "holds"
FAILS = "does not hold"
UNDECIDED = "undecided"
UNKNOWN = "not run"
SIGNIFICANT = 0.05  # p below which a difference counts
EQUAL = 0.1  # share of the return: a smaller difference, at 95 %, counts as none
WEIGHTS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of SVO
AT_CHOSEN_WEIGHT = "IPPO, SVO 90°, chosen weight"
ANGLES = (0.0, 22.5, 45.0, 67.5, 90.0)  # degrees


# Findings: which claims of the paper hold for runs under its rules. The claims are orderings in its
# tables, and its diagrams.


@dataclass(frozen=True)
class Compared:
    """A way of training that is compared with another: its name, its reward, and its results here
    and in the paper.
    """

    name: str
    reward: str
    ours: Callable[[Game], Result | None]
    theirs: Callable[[str], Printed | None]


def _with_ratio(ratio: float, name: str) -> Compared:
    """Returns the rewards of agents that exchange this share of theirs, ours and the paper's."""
    return Compared(
        name=name,
        reward=str(exchanged(ratio)["reward"]),
        ours=lambda game: game.result(exchanged(ratio)),
        theirs=lambda game: published.exchange(game).get(ratio),
    )


def _with_angle(angle: float) -> Compared:
    """Returns the rewards of agents with this angle of social value orientation, ours and the paper's."""
    return Compared(
        name=f"SVO {angle:g}°",
        reward="svo",
        ours=lambda game: game.by_angle[1].get(angle),
        theirs=lambda game: published.svo(game).get(angle),
    )


AT_NINETY = replace(_with_angle(PROSOCIAL), ours=lambda game: game.at_chosen_weight[1])
OWN = _with_ratio(0.0, "individual reward")
ALL = _with_ratio(1.0, "common reward")
HALF = _with_ratio(0.5, "exchange 0.5")
PAIRS = (  # the first is claimed to earn more than the second
    (ALL, OWN),
    (HALF, OWN),
    (HALF, ALL),
    (AT_NINETY, OWN),
    (_with_angle(67.5), OWN),
    (AT_NINETY, ALL),
)


def findings(games: Sequence[Game], frame: pd.DataFrame) -> Section:
    """Returns the first section of the page: one line for each claim."""
    suite = {game.published: game for game in games if game.published}
    claims = [_order(suite, more, less) for more, less in PAIRS]
    ratios = {name: _same_ratio(game) for name, game in suite.items()}
    claims.append(("The 95 % rule chooses the paper's ratio", "in 9 games", ratios))
    trained = _trained_diagrams(suite, frame)
    are_dilemmas = {name: _verdict(row) for name, row in trained.items()}
    claims.append(("The diagram of trained agents is a dilemma", "in 9 games", are_dilemmas))
    have_shape = {
        name: _verdict(row, published.shape(name)["shape"]) for name, row in trained.items()
    }
    claim = "The diagram of trained agents is a dilemma with the paper's fear or greed"
    claims.append((claim, "in 9 games", have_shape))
    are_equal = {name: _converge_alike(game) for name, game in suite.items()}
    claim = "IPPO with shared and with separate parameters converge alike"
    claims.append((claim, "stated, without figures", are_equal))
    rows = []
    for claim, in_paper, verdicts in claims:
        parts = []
        for verdict in (HOLDS, FAILS, UNDECIDED, UNKNOWN):
            names = [name for name in verdicts if verdicts[name] == verdict]
            if names:
                listed = "all" if len(names) == len(verdicts) else ", ".join(names)
                parts.append(f"{verdict}: {listed}")
        number = sum(verdict == HOLDS for verdict in verdicts.values())
        ours = Figure("; ".join(parts), verdicts)
        rows.append((claim, in_paper, ours, f"{number} of {len(verdicts)}"))
    headings = ("claim", "the paper", "ours", "holds in")
    table = Table("findings", "Claims of the paper", headings, rows, 3)
    return Section("Findings", (), (table,))


def _order(
    suite: Mapping[str, Game], more: Compared, less: Compared
) -> tuple[str, str, dict[str, str]]:
    """Returns the claim that one way of training earns more than another, the games in which the
    paper claims it, and verdicts by game."""
    signs: dict[str, int] = {}  # 1 if the paper claims it of a game, -1 if it claims the opposite
    for name in suite:
        first = more.theirs(name)
        second = less.theirs(name)
        if first is None or second is None:
            continue
        margin = (first.deviation or 0) + (second.deviation or 0)
        if not margin:  # the paper has no deviations of these
            margin = 0.05 * max(first.mean, second.mean)
        difference = first.mean - second.mean
        if abs(difference) > margin:
            signs[name] = 1 if difference > 0 else -1
    verdicts = {}
    for name, sign in signs.items():
        game = suite[name].with_numbers_of(more.reward)
        verdicts[name] = _order_verdict(more.ours(game), less.ours(game), sign)
    opposite = [name for name, sign in signs.items() if sign < 0]
    in_paper = f"in {len(signs) - len(opposite)} games"
    if opposite:
        in_paper += f", and less in {', '.join(opposite)}"
    return f"{more.name} earns more than {less.name}", in_paper, verdicts


def _order_verdict(more: Result | None, less: Result | None, sign: int) -> str:
    """Returns the verdict on the claim that `more` earns more than `less`; sign -1: less."""
    if more is None or less is None or more.estimate is None or less.estimate is None:
        return UNKNOWN
    comparison = compare(less.values, more.values)
    if comparison.p is None or comparison.p >= SIGNIFICANT:
        return UNDECIDED
    return HOLDS if comparison.difference * sign > 0 else FAILS


def _same_ratio(game: Game) -> str:
    """Returns the verdict on whether the 95 % rule chooses the paper's ratio, by the share of
    resamplings of seeds in which it does.

    UNKNOWN unless several seeds of all the paper's ratios were run.
    """
    values = {}
    for ratio in RATIOS:
        result = game.by_ratio.get(ratio)
        if result is None or result.estimate is None or len(result.values) < 2:
            return UNKNOWN
        values[ratio] = result.values
    share = choice_frequencies(values).get(published.exchange_chosen(game.published), 0.0)
    if share >= 1 - SIGNIFICANT:
        return HOLDS
    return FAILS if share < SIGNIFICANT else UNDECIDED


def _trained_diagrams(suite: Iterable[str], frame: pd.DataFrame) -> dict[str, Any]:
    """Returns the diagram of trained pools of each game, None if there is none; of several that
    with the most seeds."""
    trained = [
        row for row in of_record(frame, "diagram") if row.unit == TRAINED and _of_the_paper(row)
    ]
    by_game = {row.game: row for row in sorted(trained, key=lambda row: row.units)}
    return {name: by_game.get(name) for name in suite}


def _verdict(row: Any, shape: str = "") -> str:
    """Returns the verdict on the claim that a diagram is a dilemma, and one with fear or greed if
    `shape` says so.
    """
    if row is None:
        return UNKNOWN
    if row.outcome == "dilemma":
        if not shape or row[shape]:
            return HOLDS
        return FAILS if row[f"{shape}_high"] <= 0 else UNDECIDED
    return UNDECIDED if row.outcome == UNDECIDED else FAILS


def _of_the_paper(row: pd.Series) -> bool:
    """Returns whether an experiment had the paper's game, rules and numbers."""
    return bool(
        row.game in published.suite()
        and row.variant == published.variant(row.game)
        and not row.params
    )


def _converge_alike(game: Game) -> str:
    """Returns the verdict on whether the returns with shared and with separate parameters are
    equal: the interval of their difference lies within EQUAL of the larger mean.

    Individual reward counts if it was run both ways, else common reward; UNKNOWN if neither was.
    """
    first = second = None
    for method in (INDIVIDUAL, COMMON):
        if first is None or second is None:
            first = game.result(method)
            second = game.result({**method, "sharing": APART})
    if first is None or second is None or first.estimate is None or second.estimate is None:
        return UNKNOWN
    comparison = compare(first.values, second.values)
    margin = EQUAL * max(abs(first.estimate.mean), abs(second.estimate.mean))
    if comparison.low is None or comparison.high is None or comparison.p is None:
        return UNDECIDED
    if -margin <= comparison.low and comparison.high <= margin:
        return HOLDS
    return FAILS if comparison.p < SIGNIFICANT else UNDECIDED


# Individual and common reward; shared and separate parameters.


def own_and_common(games: Sequence[Game], frame: pd.DataFrame) -> Section:
    """Returns the section of IPPO with individual and with common reward."""
    random = {(row.game, row.hash): row for row in of_record(frame, "random")}
    lines: list[tuple[tuple[str, ...], Result | None, Result | None]] = []
    for game in games:
        own = game.result(INDIVIDUAL)
        common = game.result(COMMON)
        if own is None and common is None and not game.published:
            continue
        row = None
        if game.setting is not None and not game.setting.params:
            row = random.get((game.name, game.setting.hash))
        baseline = "" if row is None else interval(row.collective_return, row.low, row.high).text
        labels = (game.label, published.difficulty(game.published), baseline)
        lines.append((labels, own, common))
    words = ("game", "the paper calls it", "random policy, over episodes")
    table = compared_table(
        "own_and_common", "Collective return of IPPO", words, ("individual", "common"), lines
    )
    text = []
    for (label, *_), own, common in lines:
        sentences = differing_settings({"individual": own, "common": common}, OF_COMMON)
        text += [f"* {label}: {sentence}" for sentence in sentences]
    return Section("Individual and common reward", tuple(text), (table,))


def sharing(games: Sequence[Game]) -> Section:
    """Returns the section on ways of training that were run with both shared and separate
    parameters.
    """
    lines = []
    for game in games:
        words = [in_words(row, sharing=False) for row in game.rows.itertuples()]
        for method, seeds in game.rows.assign(method=words).groupby("method"):
            shared = result_of(select(seeds, sharing=SHARED))
            separate = result_of(select(seeds, sharing=APART))
            if shared is not None and separate is not None:
                lines.append(((game.label, method), shared, separate))
    text = []
    for (label, method), shared, separate in lines:
        sentences = differing_settings({"shared": shared, "separate": separate})
        text += [f"* {label}, {method}: {sentence}" for sentence in sentences]
    title = "Collective return with shared and with separate parameters"
    table = compared_table(
        "sharing", title, ("game", "way of training"), ("shared", "separate"), lines
    )
    return Section("Shared and separate parameters", tuple(text), (table,) if lines else ())


def mappo(games: Sequence[Game]) -> Section:
    """Returns the section of IPPO and MAPPO with common reward."""
    lines = [
        ((game.label,), game.with_numbers_of("mappo").result(COMMON), game.result(MAPPO))
        for game in games
        if game.result(MAPPO) is not None
    ]
    table = compared_table(
        "mappo", "Collective return with common reward", ("game",), ("IPPO", "MAPPO"), lines
    )
    return Section("IPPO and MAPPO", (), (table,) if lines else ())


# Tables of our results beside the published ones, three lines for each game. We run no tests against
# published figures, as the paper reports no seed counts.


def beside(
    label: str,
    results: Sequence[Result | None],
    printed: Sequence[Printed | None],
    more: Sequence[str] = (),
    theirs: Sequence[str] = (),
) -> list[tuple[str | Figure, ...]]:
    """Returns the lines of a game: our results, the published ones, and the differences with whether
    the published figure is in our interval.

    Args:
      more: the texts of further columns in our line.
      theirs: the texts of the same columns in the published line.
    """
    if not (any(results) or any(printed)):
        return []
    common, differing = _split_origins(results)
    ours = []
    for result in results:
        figure = result_figure(result)
        if result is not None:
            origins = [result.origins[index] for index in differing if result.origins[index]]
            if origins:
                figure = Figure(f"{figure.text} ({', '.join(origins)})", figure.numbers)
        ours.append(figure)
    lines: list[tuple[str | Figure, ...]] = [(label, "ours", *ours, *more, common)]
    none = ("",) * len(more)
    if any(printed):
        figures = [EMPTY if one is None else one.figure for one in printed]
        lines.append(("", "published", *figures, *(theirs or none), ""))
    differences = [_difference(result, one) for result, one in zip(results, printed, strict=True)]
    if any(figure.text for figure in differences):
        lines.append(("", "ours - published", *differences, *none, ""))
    return lines


def _split_origins(results: Sequence[Result | None]) -> tuple[str, list[int]]:
    """Returns the origins that all results of a line share (of seeds, steps, preset, hardware), and
    the indices of those that differ."""
    common = []
    differing = []
    by_kind = zip(*(result.origins for result in results if result is not None), strict=True)
    for index, origins in enumerate(by_kind):
        if len(set(origins)) > 1:
            differing.append(index)
        elif origins[0]:
            common.append(origins[0])
    return ", ".join(common), differing


def _difference(result: Result | None, printed: Printed | None) -> Figure:
    """Returns our mean minus the published one; empty without both."""
    if result is None or result.estimate is None or printed is None:
        return EMPTY
    difference = result.estimate.mean - printed.mean
    is_inside = result.estimate.low <= printed.mean <= result.estimate.high
    text = f"{'+' if difference > 0 else ''}{number(difference)}"
    if len(result.values) > 1:
        text += ", inside" if is_inside else ", outside"
    return Figure(text, {"difference": difference, "published_inside": is_inside})


def exchange(games: Sequence[Game]) -> Section:
    """Returns the section on IPPO by exchange ratio, with the ratio that the 95 % rule chooses, and
    how often it chooses each ratio in resamplings."""
    with_exchange = [
        game for game in games if game.published or "exchange" in set(game.rows.reward)
    ]
    ratios = sorted({*RATIOS, *(ratio for game in with_exchange for ratio in game.by_ratio)})
    names = {ratio: f"{ratio:g}" for ratio in ratios}
    names[0.0] = "0: individual"
    names[1.0] = "1: common"
    lines = []
    choices = []
    panels = []
    text = []
    for game in with_exchange:
        results = game.by_ratio
        printed = published.exchange(game.published)
        known = {ratio: result for ratio, result in results.items() if result.estimate is not None}
        means = {ratio: result.estimate.mean for ratio, result in known.items()}
        bold = published.exchange_chosen(game.published)
        theirs = ("" if bold is None else f"{bold:g}",)
        our_results = [results.get(ratio) for ratio in ratios]
        their_figures = [printed.get(ratio) for ratio in ratios]
        lines += beside(game.label, our_results, their_figures, (_choice(means),), theirs)
        several = {
            ratio: result.values for ratio, result in known.items() if len(result.values) > 1
        }
        if len(several) > 1:
            shares = choice_frequencies(several)
            figures = [
                Figure(f"{shares[ratio]:.1%}", {"": shares[ratio]}) if ratio in shares else EMPTY
                for ratio in (*ratios, None)
            ]
            choices.append((game.label, *figures))
        if len(means) > 1 or (means and printed):  # one point alone is no curve
            points = tuple((ratio, one.mean) for ratio, one in printed.items())
            panels.append(Multiple(game.label, (_series(results),), points))
        by_name = {names[ratio]: results.get(ratio) for ratio in ratios}
        text += [f"* {game.label}: {line}" for line in differing_settings(by_name, OF_COMMON)]
    columns = [names[ratio] for ratio in ratios]
    headings = ("game", "", *columns, "95 % rule", BEHIND)
    tables = [Table("exchange", "Collective return by exchange ratio", headings, lines, 2)]
    if choices:
        title = f"How often the rule chooses each ratio in {RESAMPLES:,} resamplings of seeds"
        tables.append(Table("exchange_choices", title, ("game", *columns, "none"), choices))
    title = "Returns by exchange ratio"
    if not panels:
        return Section(title, tuple(text), tuple(tables))
    draw = partial(draw_series, panels, "exchange ratio", "collective return")
    picture = Picture("exchange", "returns by exchange ratio", draw)
    return Section(title, tuple(text), tuple(tables), (picture,))


def _choice(means: Mapping[float, float]) -> str:
    """Returns the ratio that the rule chooses, and from how many; empty if there is only one."""
    if len(means) < 2:
        return ""
    ratio = chosen_ratio(means)
    choice = "none" if ratio is None else f"{ratio:g}"
    return choice if len(means) >= len(RATIOS) else f"{choice} of {len(means)} ratios"


def _series(results: Mapping[float, Result]) -> Series:
    """Returns the means by ratio or angle, without failed results."""
    estimates = {x: result.estimate for x, result in results.items()}
    return Series.of((x, figure) for x, figure in estimates.items() if figure is not None)


def svo(games: Sequence[Game]) -> Section:
    """Returns the section on IPPO with social value orientation: returns by weight at 90 degrees,
    and by angle at the chosen weight."""
    tables = []
    weights = sorted({*WEIGHTS, *(weight for game in games for weight in game.by_weight)})
    lines = []
    for game in games:
        if game.by_weight:
            results = [game.by_weight.get(weight) for weight in weights]
            lines += beside(game.label, results, [None] * len(weights))
    if lines:
        title = "Collective return by SVO weight, at 90 degrees"
        headings = ("game", "", *(f"{weight:g}" for weight in weights), BEHIND)
        tables.append(Table("svo_weights", title, headings, lines, 2))
    by_angle = {game.label: game.by_angle for game in games}
    angles = sorted({*ANGLES, *(angle for _, results in by_angle.values() for angle in results)})
    lines = []
    panels = []
    for game in games:
        weight, results = by_angle[game.label]
        printed = published.svo(game.published)
        weights_tried = f"{weight:g}, {tried_weights(game)}" if results else ""
        our_results = [results.get(angle) for angle in angles]
        their_figures = [printed.get(angle) for angle in angles]
        lines += beside(game.label, our_results, their_figures, (weights_tried,))
        if len(results) > 1 or (results and printed):
            points = tuple((angle, one.mean) for angle, one in printed.items())
            title = f"{game.label}, weight {weight:g}"
            panels.append(Multiple(title, (_series(results),), points))
    headings = ("game", "", *(f"{angle:g}°" for angle in angles), "weight", BEHIND)
    tables.append(Table("svo_angles", "Collective return by SVO angle", headings, lines, 2))
    title = "Social value orientation"
    if not panels:
        return Section(title, (), tuple(tables))
    draw = partial(draw_series, panels, "SVO angle (degrees)", "collective return")
    return Section(title, (), tuple(tables), (Picture("svo", "returns by SVO angle", draw),))


def tried_weights(game: Game) -> str:
    """Returns the number of weights tried at 90 degrees, in words."""
    tried = len(game.by_weight)
    return f"of {tried} tried" if tried > 1 else "no other tried"


def metrics(games: Sequence[Game]) -> Section:
    """Returns the section on how much agents cooperate, on the paper's scale, by the paper's six
    ways of training."""
    lines: list[tuple[str | Figure, ...]] = []
    for game in games:
        metric = published.metric(game.published)
        if metric is None:
            continue
        methods = (INDIVIDUAL, COMMON, MAPPO, VDN)
        results = [_on_papers_scale(game, metric, method) for method in methods]
        choices = []
        returns = {
            ratio: result.estimate.mean
            for ratio, result in game.by_ratio.items()
            if ratio > 0 and result.estimate is not None
        }
        if any(ratio != 1 for ratio in returns):  # 1 alone is common reward
            best = max(returns, key=lambda ratio: returns[ratio])
            same = game.with_numbers_of("exchange")
            results.append(_on_papers_scale(same, metric, exchanged(best)))
            choices.append(f"ratio {best:g}, the best of {len(returns)}")
        else:
            results.append(None)
        weight, prosocial = game.at_chosen_weight
        if prosocial is not None:
            method = {**SVO, "svo_angle": PROSOCIAL, "svo_weight": weight, "run": prosocial.run}
            results.append(_on_papers_scale(game, metric, method))
            choices.append(f"weight {weight:g}, {tried_weights(game)}")
        else:
            results.append(None)
        printed = [metric.printed[column] for column in published.metric_columns()]
        lines += beside(game.label, results, printed, (metric.what, "; ".join(choices)))
    headings = ("game", "", *published.metric_columns(), "figure", "chosen", BEHIND)
    table = Table("metrics", "Cooperation metric", headings, lines, 2)
    return Section("Cooperation metrics", (), (table,))


def _on_papers_scale(game: Game, metric: PaperMetric, method: Method) -> Result | None:
    """Returns our values of a metric for one way of training, on the scale of the paper.

    None if nothing was trained in this way, or in this game.
    """
    result = game.result(method, metric.measure)
    if result is None or game.setting is None:
        return None
    scale = metric.scale
    if metric.per_agent:
        scale /= game.setting.num_agents
    return replace(result, values=tuple(scale * value for value in result.values))


def over_games(games: Sequence[Game], frame: pd.DataFrame) -> Section:
    """Returns the section on scores between a random policy and the best of the paper; SVO at each
    weight, and at the one chosen in each game.

    All ways of training are compared over all of the paper's games that were run: without the games
    in which it earns little, a mean is higher.
    """
    scores = {}
    for game in games:
        best = published.best_return(game.published)
        if best is None or game.setting is None:
            continue
        words = [in_words(row) for row in game.rows.itertuples()]
        by_method = {
            method: result_of(seeds)
            for method, seeds in game.rows.assign(method=words).groupby("method")
        }
        by_method[AT_CHOSEN_WEIGHT] = game.at_chosen_weight[1]
        results = {method: result for method, result in by_method.items() if result is not None}
        scores[game.label] = score_results(frame, game.setting, best, results)
    definition = (
        "A score is (return - random) / (best published - random): 0 is a random policy, 1 the "
        "best of the paper."
    )
    if any(AT_CHOSEN_WEIGHT in of_game for of_game in scores.values()):
        definition += (
            " In each game, the chosen weight of SVO is the one of those tried that earns most."
        )
    played = [game for game, of_game in scores.items() if of_game]
    return section_over_games(scores, definition, played)


# Experiments with policies.


def diagrams(frame: pd.DataFrame) -> Section:
    """Returns the section on Schelling verdicts beside those of the paper; in each game, those
    under the paper's rules come first."""
    section = sections.diagrams(frame)
    ordered = sorted(
        of_record(frame, "diagram"),
        key=lambda row: (
            sort_key(row.game),
            not _of_the_paper(row),
            setting_of(row).label,
            row.unit != TRAINED,
            row.cooperators,
        ),
    )
    rows: list[tuple[str | Figure, ...]] = []
    for name in dict.fromkeys((*published.suite(), *(row.game for row in ordered))):
        of_game = [row for row in ordered if row.game == name]
        lines = diagram_rows(of_game)
        in_paper = ""
        if shape := published.shape(name):
            note = f" ({shape['note']})" if shape["note"] else ""
            in_paper = f"{shape['shape']}, called a {shape['type']}{note}"
            if not of_game or not _of_the_paper(of_game[0]):
                lines.insert(0, (f"{name}, variant {published.variant(name)}", *("",) * 8))
        for index, (*figures, samples) in enumerate(lines):
            rows.append((*figures, in_paper if index == 0 else "", samples))
    headings = (
        "game",
        "cooperators",
        "defectors",
        "A",
        "B",
        "fear",
        "greed",
        "verdict",
        "published",
        "over",
    )
    table = Table("schelling", "Contrasts of the return of an agent", headings, rows, 3)
    return replace(section, tables=(table,))
