"""Findings: which claims of the paper hold for runs under its rules, a line a claim. The claims are orders in its tables and its diagrams."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from sjdsl.experiments.published import published_shape
from sjdsl.report import published
from sjdsl.report.cells import Cell
from sjdsl.report.contents import Contents, Game
from sjdsl.report.page import Section, Table
from sjdsl.report.published import Printed
from sjdsl.report.sections.diagrams import TRAINED
from sjdsl.report.sections.svo import by_angle
from sjdsl.report.ways import APART, SHARED, common, exchanged, individual, is_ippo
from sjdsl.report.welch import compare

HOLDS, FAILS, UNDECIDED, UNKNOWN = "holds", "does not hold", "undecided", "not run"
SURE = 0.05  # p below which a difference counts
ALIKE = 0.1  # of the return: ways whose difference is smaller, at 95 %, count as alike

Earned = Callable[[Contents, Game], Cell | None]
Paper = Callable[[str], Printed | None]


@dataclass(frozen=True)
class Compared:
    """A way of training that is compared with another: its name, what it earned here and in the paper."""

    name: str
    ours: Earned
    theirs: Paper


@dataclass(frozen=True)
class Finding:
    """A claim, and in which games the paper has it; by game what was found here."""

    claim: str
    theirs: str
    verdicts: Mapping[str, str]


def findings(contents: Contents) -> Section:
    """Returns the section with which the page of the whole suite begins."""
    found = [*(_ordered(contents, more, less) for more, less in PAIRS), _diagrams(contents), _sharing(contents)]
    rows = tuple((finding.claim, finding.theirs, _games(finding), _share(finding)) for finding in found)
    records = tuple(
        {"claim": finding.claim, "game": game, "verdict": verdict} for finding in found for game, verdict in finding.verdicts.items()
    )
    text = (
        "Each claim was tried with runs under the rules that the paper played. A claim about returns is decided in a game if p is below "
        f"{SURE} (Welch, over seeds): it holds if the difference has the paper's sign. Else it is undecided. The paper claims an order where its means differ by more than what it prints after ±, or by 5 % where it prints none.",
        "A claim about a diagram holds if the verdict over training seeds is a dilemma with the paper's fear or greed. "
        f"Ways converge alike if the 95 % interval of the difference lies within {ALIKE:.0%} of the return.",
    )
    headings = ("claim", "the paper", "ours", "holds in")
    return Section("Findings", text, (Table("findings", "Claims of the paper", headings, rows, records, 3),))


def _suite(contents: Contents) -> Iterator[Game]:
    return (game for game in contents.games if game.published)


def _games(finding: Finding) -> str:
    """Returns the games of each verdict."""
    parts = []
    for verdict in (HOLDS, FAILS, UNDECIDED, UNKNOWN):
        games = [game for game, found in finding.verdicts.items() if found == verdict]
        names = "all" if len(games) == len(finding.verdicts) else ", ".join(games)
        parts += [f"{verdict}: {names}"] if games else []
    return "; ".join(parts)


def _share(finding: Finding) -> str:
    return f"{sum(found == HOLDS for found in finding.verdicts.values())} of {len(finding.verdicts)}"


def _ordered(contents: Contents, more: Compared, less: Compared) -> Finding:
    """Returns what was found of the order of two ways of training, in the games in which the paper has one."""
    signs: dict[str, int] = {}
    for name in published.suite():
        first, second = more.theirs(name), less.theirs(name)
        if first is not None and second is not None:
            margin = (first.deviation or 0) + (second.deviation or 0) or 0.05 * max(first.mean, second.mean)
            difference = first.mean - second.mean
            signs |= {name: 1 if difference > 0 else -1} if abs(difference) > margin else {}
    verdicts = {}
    for game in _suite(contents):
        if game.name in signs:
            verdicts[game.name] = _sign(more.ours(contents, game), less.ours(contents, game), signs[game.name])
    other = [name for name, sign in signs.items() if sign < 0]
    theirs = f"in {len(signs) - len(other)} games" + (f", and less in {', '.join(other)}" if other else "")
    return Finding(f"{more.name} earns more than {less.name}", theirs, verdicts)


def _sign(more: Cell | None, less: Cell | None, wanted: int) -> str:
    if more is None or less is None or more.estimate is None or less.estimate is None:
        return UNKNOWN
    found = compare(less.values, more.values)
    if found.p is None or found.p >= SURE:
        return UNDECIDED
    return HOLDS if found.difference * wanted > 0 else FAILS


def _diagrams(contents: Contents) -> Finding:
    found = {row.game: row for row in contents.evidence.diagrams if row.unit == TRAINED and contents.of_the_paper(row)}
    verdicts = {}
    for name in published.suite():
        shape, row = (published_shape(name) or {}).get("shape"), found.get(name)
        if row is None:
            verdicts[name] = UNKNOWN
        elif row.outcome == "dilemma":
            verdicts[name] = HOLDS if (row.fear if shape == "fear" else row.greed) else UNDECIDED
        else:
            verdicts[name] = UNDECIDED if row.outcome == UNDECIDED else FAILS
    return Finding("The trained diagram is a dilemma, with the fear or the greed that it names", "in 9 games", verdicts)


def _sharing(contents: Contents) -> Finding:
    verdicts = {}
    for game in _suite(contents):
        cells = [_returns(way)(contents, game) for way in (individual, lambda run: is_ippo(run, APART) and run.reward == "individual")]
        if None in cells:
            cells = [_returns(way)(contents, game) for way in (common, lambda run: is_ippo(run, APART) and run.reward == "common")]
        verdicts[game.name] = _alike(*cells)
    return Finding(f"IPPO with {SHARED} and with separate parameters converge alike", "said, without figures", verdicts)


def _alike(first: Cell | None, second: Cell | None) -> str:
    if first is None or second is None or first.estimate is None or second.estimate is None:
        return UNKNOWN
    found, margin = compare(first.values, second.values), ALIKE * max(abs(first.estimate.mean), abs(second.estimate.mean))
    if found.low is None or found.high is None or found.p is None:
        return UNDECIDED
    if -margin <= found.low and found.high <= margin:
        return HOLDS
    return FAILS if found.p < SURE else UNDECIDED


def _returns(way: Callable[..., bool]) -> Earned:
    return lambda contents, game: None if game.setting is None else contents.index.returns(game.setting, way)


def _exchange(ratio: float, name: str) -> Compared:
    return Compared(name, _returns(exchanged(ratio)), lambda game: published.exchange(game).get(ratio))


def _angle(angle: float, contents: Contents, game: Game) -> Cell | None:
    return by_angle(contents, game)[1].get(angle)


def _svo(angle: float) -> Compared:
    return Compared(f"SVO {angle:g}°", partial(_angle, angle), lambda game: published.svo(game).get(angle))


OWN, COMMON, HALF = _exchange(0.0, "individual reward"), _exchange(1.0, "common reward"), _exchange(0.5, "exchange 0.5")
PAIRS = ((COMMON, OWN), (HALF, OWN), (HALF, COMMON), (_svo(90.0), OWN), (_svo(67.5), OWN), (_svo(90.0), COMMON))
