"""The sections of a report: each is a function of the table of results, and makes its tables and
pictures.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import count, groupby
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.render.line_plots import Line, draw_panels, split_lines
from sjdsl.render.plot_style import line_colour
from sjdsl.results.figures import (
    Figure,
    Result,
    Table,
    comparison_figures,
    counted,
    interval,
    result_figure,
    short,
)
from sjdsl.results.loading import CONTRASTS, HELD_OUT, MINUS_HELD_OUT
from sjdsl.results.page import Picture, Section
from sjdsl.results.selecting import Setting, games, in_words, result_of, setting_of
from sjdsl.results.settings import as_written, differing, settings_of
from sjdsl.results.statistics import compare, draw_profiles, improvements, interquartile_means
from sjdsl.short_paths import short_names
from sjdsl.trainers.policies.estimates import estimate, stack_estimates
from sjdsl.trainers.policies.stored_evaluation import RETURN
from sjdsl.trainers.settings.own_settings import OWN

if TYPE_CHECKING:
    import pandas as pd

BEHIND = "seeds, steps, preset, hardware"
SHORT_NAMES = (
    "A policy's name is the part of its path that tells it apart in its game; the CSV has whole "
    "paths."
)
# Intervals over episodes say nothing about other training seeds.
OF_POLICIES = ", of these policies only"
Pair = tuple[tuple[str, ...], Result | None, Result | None]  # labels, and two results
# game -> way of training -> its result, and the scores of its seeds
Scores = Mapping[Any, Mapping[str, tuple[Result, np.ndarray]]]


def ways_of_training(rows: "pd.DataFrame") -> Iterator[tuple[str, "pd.DataFrame"]]:
    """Yields the ways of training in one game, in words, and their seeds.

    If two have the same words, the settings that differ are added.
    """
    runs = [(in_words(seeds.iloc[0]), seeds) for _, seeds in rows.groupby("run")]
    for words, seeds in sorted(runs, key=lambda pair: (pair[0].casefold(), pair[1].iloc[0].run)):
        first = seeds.iloc[0]
        others = [
            other.iloc[0]
            for other_words, other in runs
            if other_words == words and other.iloc[0].run != first.run
        ]
        settings = _all_settings(first)
        parts = []
        for name in differing([settings, *map(_all_settings, others)]):
            if name in settings or name.startswith(OWN):
                value = as_written(settings.get(name, "default"))
                parts.append(f"{name} {value or 'none'}")
        if others and not parts:
            parts.append(first.run[-8:])
        yield f"{words} ({', '.join(parts)})" if parts else words, seeds


def _all_settings(row: Any) -> dict[str, Any]:
    """Returns the settings of a seed that `in_words` doesn't say."""
    return settings_of(row) | {"network": row.network, "total_timesteps": int(row.total_timesteps)}


def returns(frame: "pd.DataFrame") -> Section:
    """Returns the section on the return of each way of training in each game."""
    rows = []
    for setting, of_game in games(frame):
        for words, seeds in ways_of_training(of_game):
            result = result_of(seeds)
            if result is not None:
                rows.append((setting.label, words, result_figure(result), result.origin))
    headings = ("game", "way of training", "collective return", BEHIND)
    table = Table("returns", "Collective return", headings, rows, 2)
    return Section("Returns", (), (table,) if rows else ())


def splits_in(frame: "pd.DataFrame") -> list[str]:
    """Returns the splits whose held-out tasks some seed was evaluated in, in order."""
    names = (name for name in frame if name.startswith(MINUS_HELD_OUT))
    return sorted(name.removeprefix(MINUS_HELD_OUT) for name in names)


def held_out(frame: "pd.DataFrame") -> Section:
    """Returns the section on the return in training tasks and in the held-out tasks of each
    split.
    """
    rows: list[tuple[str | Figure, ...]] = []
    for setting, of_game in games(frame):
        for words, seeds in ways_of_training(of_game):
            for split in splits_in(frame):
                minus = result_of(seeds, f"{MINUS_HELD_OUT}{split}")
                if minus is None or not minus.values:
                    continue
                sides = (result_of(seeds), result_of(seeds, f"{RETURN}{HELD_OUT}{split}"))
                figures = (result_figure(result) for result in (*sides, minus))
                rows.append((setting.label, words, split, *figures))
    headings = ("game", "way of training", "split", "training", "held out", "training - held out")
    title = "Collective return in training tasks and in held-out tasks"
    text = "The difference is taken seed by seed, and its interval is over training seeds."
    table = Table("held_out", title, headings, rows, 3)
    return Section("Held-out tasks", (text,), (table,) if rows else ())


def trials(frame: "pd.DataFrame") -> Section:
    """Returns the section on the return in each trial, in games whose episodes have trials."""
    rows = []
    for setting, of_game in games(frame):
        for words, seeds in ways_of_training(of_game):
            for side in ("", *(f"{HELD_OUT}{split}" for split in splits_in(frame))):
                for trial in count():
                    result = result_of(seeds, f"collective return of trial {trial}{side}")
                    if result is None or not result.values:
                        break
                    label = f"{trial}{side}"
                    rows.append((setting.label, words, label, result_figure(result)))
    headings = ("game", "way of training", "trial", "collective return")
    table = Table("trials", "Collective return by trial", headings, rows, 3)
    text = "Each trial begins anew, so what rises from trial to trial is what agents find out."
    return Section("Trials", (text,), (table,) if rows else ())


def compared_table(
    name: str, title: str, words: Sequence[str], columns: tuple[str, str], lines: Sequence[Pair]
) -> Table:
    """Returns a table of pairs of results, with their difference, its 95 % interval, and p."""
    rows: list[tuple[str | Figure, ...]] = []
    for labels, first, second in lines:
        comparison = None
        if first and second and first.estimate is not None and second.estimate is not None:
            comparison = compare(first.values, second.values)
        origins = dict.fromkeys(result.origin for result in (first, second) if result is not None)
        figures = (result_figure(first), result_figure(second), *comparison_figures(comparison))
        rows.append((*labels, *figures, "; ".join(origins)))
    difference = f"{columns[1]} - {columns[0]}"
    headings = (*words, *columns, difference, "p (Welch)", BEHIND)
    return Table(name, title, headings, rows, len(words))


def learning_curves(frame: "pd.DataFrame", curves: "pd.DataFrame") -> Section:
    """Returns the section with a picture for each game: the mean over seeds with a band for its 95
    % interval (Student's t).
    """
    pictures = []
    colours: dict[str, str] = {}  # a way of training has one in all games
    for setting, of_game in games(frame):
        lines = _lines_of_game(of_game, curves, colours)
        if lines:
            pictures.append(_picture_of_lines(setting.label, lines))
    text = [
        "Mean over seeds, with a band for its 95 % interval (Student's t). A single seed has no "
        "band."
    ]
    if (frame.algorithm == "vdn").any():
        text.append(
            "The curves of VDN are from episodes in which it explores. The tables evaluate its "
            "last policies without exploration."
        )
    if (frame.status == "failed").any():
        text.append("Ways of training with a failed seed have no curve.")
    return Section("Learning curves", tuple(text), pictures=tuple(pictures))


def _lines_of_game(
    of_game: "pd.DataFrame", curves: "pd.DataFrame", colours: dict[str, str]
) -> list[tuple[Line, int]]:
    """Returns the line of each way of training without a failed seed, with its number of seeds.

    Args:
      colours: of the ways of training so far; those of new ones are added.
    """
    lines = []
    failed = of_game[of_game.status == "failed"].run
    for words, seeds in ways_of_training(of_game[~of_game.run.isin(failed)]):
        points = curves[curves.run == seeds.iloc[0].run]
        by_step = points.pivot(index="env_steps", columns="seed", values="collective_return")
        by_step = by_step.dropna()  # the steps that all seeds have
        if not by_step.empty:
            colour = colours.setdefault(words, line_colour(len(colours)))
            lines.append((replace(_line(words, by_step), colour=colour), by_step.shape[1]))
    return lines


def _picture_of_lines(title: str, lines: Sequence[tuple[Line, int]]) -> Picture:
    """Returns a game's picture of lines and their numbers of seeds.

    The number stands below if it is the same for all lines, else in the label of each.
    """
    numbers = {number for _, number in lines}
    if len(numbers) == 1:
        samples = counted(numbers.pop(), "seed")
        labelled = [line for line, _ in lines]
    else:
        samples = "seeds"
        labelled = [
            replace(line, label=f"{line.label}, {counted(number, 'seed')}")
            for line, number in lines
        ]
    note = f"Lines: means over {samples}. Bands: 95 % intervals."
    panels = split_lines(labelled, "collective return of an episode")
    name = re.sub(r"[^\w.-]+", "_", f"curves_{title}")
    return Picture(name, title, partial(draw_panels, panels, title, note))


def _line(words: str, by_step: "pd.DataFrame") -> Line:
    """Returns the curve of a way of training: returns by step and seed."""
    steps = by_step.index.to_numpy(float)
    values = by_step.to_numpy(float)
    if values.shape[1] < 2:
        return Line(words, steps, values[:, 0])
    mean, low, high = stack_estimates(estimate(row) for row in values)
    return Line(words, steps, mean, low, high, least=float(values.min()))


def over_games(frame: "pd.DataFrame") -> Section:
    """Returns the section on statistics over games, with scores between a random policy and the
    best way of training in each game.
    """
    scores = {}
    for setting, of_game in games(frame):
        results = {}
        for words, seeds in ways_of_training(of_game):
            result = result_of(seeds)
            if result is not None:
                results[words] = result
        estimates = [result.estimate for result in results.values() if result.estimate is not None]
        best = max((figure.mean for figure in estimates), default=0.0)
        scores[setting.label] = score_results(frame, setting, best, results)
    definition = (
        "A score is (return - random) / (best - random): "
        "0 is a random policy, 1 the best way of training here."
    )
    return section_over_games(scores, definition, chosen_games(scores))


def score_results(
    frame: "pd.DataFrame", setting: Setting, best: float, results: Mapping[str, Result]
) -> dict[str, tuple[Result, np.ndarray]]:
    """Returns each result with at least two seeds, and the scores of its seeds (`[S]`): 0 is the
    return of a random policy, 1 is `best`.

    Empty if no random policy was played, the game has changed numbers, or `best` isn't better.
    """
    is_random = frame.record == "random"
    of_game = (frame.game == setting.game) & (frame.hash == setting.hash)
    of_game &= frame.tasks == setting.tasks
    random_returns = frame[is_random & of_game].collective_return
    if random_returns.empty or setting.params or best <= random_returns.iloc[-1]:
        return {}
    random = random_returns.iloc[-1]
    scores = {}
    for way, result in results.items():
        if result.estimate is not None and len(result.values) > 1:
            scores[way] = (result, (np.array(result.values) - random) / (best - random))
    return scores


def section_over_games(scores: Scores, definition: str, chosen: Sequence[str]) -> Section:
    """Returns the section on ways of training with at least two seeds in each of the chosen games;
    surplus seeds are left out. definition: what a score is, a sentence."""
    text = [
        f"{definition} The 95 % intervals are from resampling the seeds of each game (stratified "
        "bootstrap). Scores describe the games together, not any one of them."
    ]
    tables = {}  # way of training -> scores [seeds, games]
    behind = {}  # way of training -> its seeds, steps, preset and hardware
    remarks = []
    left_out = []
    for way in sorted({way for of_game in scores.values() for way in of_game}):
        number = sum(way in scores[game] for game in chosen)
        if number < len(chosen):
            left_out.append(f"{way} ({number} of {len(chosen)})")
            continue
        results, values = zip(*(scores[game][way] for game in chosen), strict=True)
        fewest = min(map(len, values))
        if max(map(len, values)) > fewest:
            remarks.append(
                f"* For {way}, only the first {fewest} seeds of each game are used, as some games "
                "have no more."
            )
        tables[way] = np.stack([of_game[:fewest] for of_game in values], axis=1)
        steps = sorted({result.steps for result in results})
        lengths = " to ".join(dict.fromkeys((short(steps[0]), short(steps[-1]))))
        origins: dict[str, None] = {}  # preset and hardware of each, without repetition
        for result in results:
            _, _, preset, hardware = result.origins
            origins[", ".join(filter(None, (preset, hardware)))] = None
        behind[way] = (
            f"{counted(fewest, 'seed')}, {len(chosen)} games, {lengths} steps, "
            f"{' and '.join(origins)}"
        )
    if len(chosen) < 2 or not tables:
        none = (
            "Too few results yet: this takes at least two games with a random policy, and a way of "
            "training with two seeds in each."
        )
        return Section("Over games", (*text, none))
    if left_out:
        remarks.append(
            f"* Left out, because they were not run in all of these games: {'; '.join(left_out)}."
        )
    text.append(f"Games: {'; '.join(chosen)}.")
    if remarks:
        text.append("\n".join(remarks))
    means = [
        (way, interval(*mean), behind[way]) for way, mean in interquartile_means(tables).items()
    ]
    title = "Interquartile mean of the scores"
    headings = ("way of training", "interquartile mean", BEHIND)
    section_tables = [Table("over_games", title, headings, means)]
    if len(tables) > 1:
        title = (
            "Probability that a seed of the first way earns more than one of the second, "
            "averaged over games"
        )
        rows = [
            (first, second, interval(*probability))
            for (first, second), probability in improvements(tables).items()
        ]
        headings = ("way of training", "over", "probability")
        section_tables.append(Table("improvement", title, headings, rows, 2))
    draw = partial(draw_profiles, tables)
    picture = Picture("performance_profiles", "performance profiles", draw)
    return Section("Over games", tuple(text), tuple(section_tables), (picture,))


def chosen_games(scores: Mapping[Any, Mapping[str, Any]]) -> list[Any]:
    """Returns the set of at least two games that keeps the most pairs of a game and a way of
    training; empty if there is none.

    If possible, at least two ways have all of the games. Ties go to more games, then to the first
    in their order. Only sets of games that some ways have in common are considered, as larger ones
    wouldn't have more ways.
    """
    order = list(scores)
    all_ways = {way for of_game in scores.values() for way in of_game}
    games_of_ways = [frozenset(game for game in order if way in scores[game]) for way in all_ways]
    common: set[frozenset[Any]] = set()  # all intersections of some of these
    for games_of_way in games_of_ways:
        common |= {games_of_way & other for other in common}
        common.add(games_of_way)
    sets = [[game for game in order if game in chosen] for chosen in common if len(chosen) > 1]

    def worth(chosen: Sequence[Any]) -> tuple[Any, ...]:
        number = sum(set(chosen) <= games_of_way for games_of_way in games_of_ways)
        position = [-order.index(game) for game in chosen]
        return number > 1, number * len(chosen), len(chosen), position

    return max(sets, key=worth, default=[])


def diagrams(frame: "pd.DataFrame") -> Section:
    """Returns the section on the contrasts and the verdict of each Schelling diagram."""
    rows = diagram_rows(of_record(frame, "diagram"))
    text = [
        "A: all cooperate minus all defect. B: cooperating together minus cooperating alone. "
        "Fear: defecting minus cooperating while the "
        "others defect. Greed: the same while the others cooperate.",
        "The four intervals hold jointly at 95 %. In a dilemma, A and B are above 0, and so is "
        "fear or greed.",
        SHORT_NAMES,
        *(
            f"{setting_of(row).label}: {row.caution}"
            for row in of_record(frame, "diagram")
            if row.caution
        ),
    ]
    headings = ("game", "cooperators", "defectors", "A", "B", "fear", "greed", "verdict", "over")
    table = Table("schelling", "Contrasts of the return of an agent", headings, rows, 3)
    return Section("Schelling diagrams", tuple(text), (table,) if rows else ())


def of_record(frame: "pd.DataFrame", record: str) -> Iterator[Any]:
    """Yields the rows of one kind of record."""
    return (row for _, row in frame[frame.record == record].iterrows())


def diagram_rows(diagrams: Iterable[Any]) -> list[tuple[str | Figure, ...]]:
    """Returns the table results of diagrams, with short names of the policies of each game."""
    rows: list[tuple[str | Figure, ...]] = []
    for _, group in groupby(diagrams, attrgetter("game")):
        of_game = list(group)
        policies = [row.cooperators for row in of_game] + [row.defectors for row in of_game]
        names = short_names(policies)
        rows += [_diagram_row(row, names) for row in of_game]
    return rows


def _diagram_row(row: Any, names: Mapping[str, str]) -> tuple[str | Figure, ...]:
    """Returns a line of the table of diagrams. names: the short name of each policy."""
    contrasts = [
        interval(row[f"{name}_mean"], row[f"{name}_low"], row[f"{name}_high"]) for name in CONTRASTS
    ]
    shape = " and ".join(name for name in ("fear", "greed") if row[name])
    verdict = f"dilemma, {shape}" if row.outcome == "dilemma" else row.outcome
    cooperators = _policy_figure(names[row.cooperators], row.cooperators)
    defectors = _policy_figure(names[row.defectors], row.defectors)
    label = setting_of(row).label
    return label, cooperators, defectors, *contrasts, verdict, _sample_text(row)


def _rename_in(text: str, names: Mapping[str, str]) -> str:
    """Returns a text with each of these names replaced by its new one."""
    known = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.sub(known, lambda match: names[match[0]], text)


def _policy_figure(short: str, name: str) -> Figure:
    """Returns a policy's short name for the page, with its whole one for the CSV."""
    return Figure(f"`{short}`", {"": f"`{name}`"})


def _sample_text(row: Any) -> str:
    """Returns what the intervals of an experiment are over: `3 training seeds`."""
    text = f"{row.units} {row.unit}s"
    return text if row.unit == "training seed" else text + OF_POLICIES


def cross_play(frame: "pd.DataFrame") -> Section:
    """Returns the section on cross-play: a table of what agents earn beside other policies.

    Args:
      frame: from `results.load`. A row whose `record` is "mixture" has the mean
        return of an agent of one `policy` in one `mixture` of policies. The rows of a game stand
        together; a policy's short name is unique in its game.
    """
    rows: list[tuple[str | Figure, ...]] = []
    for _, group in groupby(of_record(frame, "mixture"), attrgetter("game")):
        results_of_game = list(group)
        names = short_names(result.policy for result in results_of_game)
        for result in results_of_game:
            mixture = Figure(_rename_in(result.mixture, names), {"": result.mixture})
            policy = _policy_figure(names[result.policy], result.policy)
            earned = interval(result["mean"], result.low, result.high)
            rows.append((setting_of(result).label, mixture, policy, earned, _sample_text(result)))
    headings = ("game", "mixture", "policy", "return of an agent", "interval over")
    title = "Return of an agent of a policy in a mixture, with its 95 % interval"
    table = Table("cross_play", title, headings, rows, 3)
    return Section("Cross-play", (SHORT_NAMES,), (table,) if rows else ())


def report_sections(frame: "pd.DataFrame", curves: "pd.DataFrame") -> list[Section]:
    """Returns the sections of a report that have something to show."""
    summaries = (
        returns(frame),
        held_out(frame),
        trials(frame),
        learning_curves(frame, curves),
        over_games(frame),
    )
    sections = (*summaries, diagrams(frame), cross_play(frame))
    return [section for section in sections if section.tables or section.pictures]
