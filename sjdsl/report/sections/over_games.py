"""Over games: interquartile mean, performance profiles and probability of improvement of normalised scores, all by `rliable`."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from hashlib import sha256
from typing import Any

import numpy as np

from sjdsl.report import published
from sjdsl.report.cells import Cell, each_once, short, shown
from sjdsl.report.contents import Contents, Game, called
from sjdsl.report.evidence import Run
from sjdsl.report.figure_text import bounded
from sjdsl.report.page import Picture, Section, Table
from sjdsl.report.rliable_statistics import INSTALL, Interval, draw_profiles, improvements, interquartile_means, is_installed
from sjdsl.report.sections.svo import by_angle
from sjdsl.report.ways import CHOSEN_WEIGHT, in_words

TITLE = "Over games"
Scores = dict[str, np.ndarray]  # way of training -> [seeds, games]


@dataclass(frozen=True)
class Origin:
    """Where the scores of a way of training come from, in all games: the fewest and the most environment steps of a seed, and the hardware."""

    fewest: int
    most: int
    hardware: str

    def __str__(self) -> str:
        steps = short(self.most) if self.fewest == self.most else f"{short(self.fewest)} to {short(self.most)}"
        return f"{steps} steps, {shown(self.hardware)}"


def over_games(contents: Contents) -> Section:
    """Returns the section of the ways of training that were tried in the same two games or more, with two seeds at least."""
    games, scores, origins, remarks = _scores_of(contents)
    text = [
        "A score is (return - random) / (best published - random): 0 is a random policy, 1 the best of the paper. "
        "Intervals are of 95 %, by resampling the seeds of each game (stratified bootstrap). None of this says anything of a single game.",
        *(["\n".join(remarks)] if remarks else []),
    ]
    if len(scores) < 1:
        wanted = _without_random(contents)
        fill = [
            f"sjdsl crossplay {called([name], published.variant(name))} --policies random --episodes 200 -o runs/{name}_random"
            for name in wanted
        ]
        return Section(
            TITLE, (*text, "There are no two games yet with the same way of training, two seeds, and a random policy."), fill=tuple(fill)
        )
    text.append(f"Of the games {', '.join(games)}.")
    stamp = sha256(
        json.dumps([games, {way: [found.tolist(), astuple(origins[way])] for way, found in scores.items()}]).encode()
    ).hexdigest()[:12]
    if not is_installed():
        return Section(TITLE, (*text, INSTALL), stamp=stamp, lacks=INSTALL)
    tables = [_means_table(interquartile_means(scores), scores, origins)]
    if len(scores) > 1:
        tables.append(_improvement_table(improvements(scores)))
    pictures = (Picture("performance_profiles", "performance profiles", partial(draw_profiles, scores)),)
    return Section(TITLE, tuple(text), tuple(tables), pictures, stamp=stamp)


def _scores_of(contents: Contents) -> tuple[list[str], Scores, dict[str, Origin], list[str]]:
    """Returns the games, the scores of each way of training in them and where they come from, and what must be said of the choice.

    The games are those in which most can be compared (`_chosen_games`); ways that lack one of them are left out, and seeds beyond the
    fewest.
    """
    found: dict[str, dict[str, tuple[Cell, np.ndarray]]] = {}
    for game in contents.games:
        for way, tried in _scores_in(contents, game).items():
            found.setdefault(way, {})[game.label] = tried
    games = _chosen_games([game.label for game in contents.games], found)
    if not games:
        return [], {}, {}, []
    scores, origins, remarks = {}, {}, []
    others = sorted({game for by_game in found.values() for game in by_game} - set(games))
    if others:
        remarks.append(f"* Left out for games in which more ways of training can be compared: {', '.join(others)}.")
    if any(way.endswith(CHOSEN_WEIGHT) for way in found):
        remarks.append("* The chosen weight of SVO is that of each game's own sweep.")
    for way, by_game in sorted(found.items()):
        if not set(games) <= by_game.keys():
            remarks.append(f"* {way} is left out: it lacks {', '.join(game for game in games if game not in by_game)}.")
            continue
        cells, values = zip(*(by_game[game] for game in games), strict=True)
        fewest = min(map(len, values))
        if max(map(len, values)) > fewest:
            remarks.append(f"* Of {way} the first {fewest} seeds of each game are taken, for in some games there are no more.")
        scores[way] = np.stack([each[:fewest] for each in values], axis=1)
        steps = [cell.steps for cell in cells]
        origins[way] = Origin(min(steps), max(steps), each_once(cell.hardware for cell in cells))
    return games, scores, origins, remarks


def _chosen_games(order: Sequence[str], found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Returns the games, two at least, in which the most pairs of a game and a way of training are left; none where there are no two.

    If possible, two ways have all of them. Of sets with as many pairs it is the one with more games, then the first in their order.
    Larger sets than those that some ways have in common would not have more ways, so these are all that are looked at.
    """
    common: set[frozenset[str]] = set()
    for by_game in found.values():
        own = frozenset(by_game)
        common |= {own} | {own & other for other in common}
    sets = [[game for game in order if game in games] for games in common if len(games) > 1]

    def worth(games: Sequence[str]) -> tuple[Any, ...]:
        ways = sum(set(games) <= by_game.keys() for by_game in found.values())
        return ways > 1, ways * len(games), len(games), [-order.index(game) for game in games]

    return max(sets, key=worth, default=[])


def _scores_in(contents: Contents, game: Game) -> Mapping[str, tuple[Cell, np.ndarray]]:
    """Returns the cell and the scores of its seeds by way of training; of two seeds at least."""
    best = published.best_return(game.published)
    random = None if game.setting is None else contents.index.random(game.setting.game, game.setting.hash)
    if best is None or random is None or game.setting is None:
        return {}
    scores = {}
    weight, _ = by_angle(contents, game)
    for way in sorted({in_words(run, weight) for run in contents.index.runs(game.setting) if run.stage != 1}):
        cell = contents.index.returns(game.setting, partial(_is, way, weight))
        if cell is not None and cell.estimate is not None and len(cell.values) > 1:
            scores[way] = cell, (np.array(cell.values) - random.mean) / (best - random.mean)
    return scores


def _is(way: str, chosen_weight: float, run: Run) -> bool:
    return run.stage != 1 and in_words(run, chosen_weight) == way


def _without_random(contents: Contents) -> list[str]:
    settings = [game.setting for game in contents.games if game.setting is not None and game.published]
    names = [s.game for s in settings if published.best_return(s.game) is not None and contents.index.random(s.game, s.hash) is None]
    return list(dict.fromkeys(names))


def _means_table(means: Mapping[str, Interval], scores: Scores, origins: Mapping[str, Origin]) -> Table:
    rows, records = [], []
    for way, (mean, low, high) in means.items():
        (seeds, games), origin = scores[way].shape, origins[way]
        rows.append((way, bounded(mean, low, high), f"{seeds} seeds, {games} games, {origin}"))
        figures = {"way": way, "iqm": mean, "low": low, "high": high, "seeds": seeds, "games": games}
        records.append(figures | {"fewest_steps": origin.fewest, "most_steps": origin.most, "hardware": origin.hardware})
    headings = ("way of training", "interquartile mean", "seeds, games, steps, hardware")
    return Table("over_games", "Interquartile mean of the scores", headings, tuple(rows), tuple(records))


def _improvement_table(found: Mapping[tuple[str, str], Interval]) -> Table:
    rows = [(first, second, bounded(*interval)) for (first, second), interval in found.items()]
    records = [
        {"way": first, "over": second, "probability": p, "low": low, "high": high} for (first, second), (p, low, high) in found.items()
    ]
    headings = ("way of training", "over", "probability")
    return Table(
        "improvement",
        "Probability that a seed of the first way earns more than one of the second, on average over games",
        headings,
        tuple(rows),
        tuple(records),
        2,
    )
