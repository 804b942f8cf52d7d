"""Schelling verdicts: whether a game is a dilemma to the policies that were learnt, beside what the paper found."""

from typing import Any

from sjdsl.experiments.published import published_shape
from sjdsl.report.contents import Contents, called, in_folder, sweeps_of
from sjdsl.report.evidence import DiagramRow
from sjdsl.report.figure_text import bounded
from sjdsl.report.page import Section, Table
from sjdsl.report.published import variant
from sjdsl.report.sections.own_and_common import AXIS, REWARDS, pools

HEADINGS = (*("game", "cooperators", "defectors", "A", "B", "fear", "greed", "verdict", "published", "over"),)


TRAINED = "training seed"  # the unit of diagrams of pools


def diagrams(contents: Contents) -> Section:
    """Returns the section of the contrasts of each diagram, and its verdict."""
    found = contents.evidence.diagrams
    own = [row for row in found if not contents.form(row)]
    trained = {row.game for row in own if row.unit == TRAINED}
    theirs = {row.game for row in found if row.unit == TRAINED and contents.of_the_paper(row)}
    wanted = [(name, contents.wanted_variant(name)) for name in contents.plain_names]
    missing = [(name, form) for name, form in wanted if name not in (theirs if form else trained)]
    rows = [row for name in contents.names for row in _rows(contents, name)]
    records = tuple(_record(contents, row) for row in found)
    text = [
        "A: all cooperating against all defecting. B: cooperating together against cooperating alone. Fear: defecting against cooperating "
        "where the others defect. Greed: the same where the others cooperate.",
        "The intervals of the four hold together at 95 %. A dilemma has A and B above 0, and fear or greed.",
    ]
    if {row.game for row in own} - trained:
        text.append("Where a game has only rows over episodes, the diagram over training seeds is missing: its command is below.")
    cautions = tuple(f"{_label(contents, row)}: {row.caution}" for row in found if row.caution)
    title = "Contrasts of the return of an agent"
    tables = (Table("schelling", title, HEADINGS, tuple(rows), records, 3),) if rows else ()
    fill = []
    for name, form in missing:
        cooperators, defectors = pools(name, form)
        command = f"sjdsl schelling {called([name], form)} --cooperators {cooperators} --defectors {defectors}"
        fill.append(f"{command} -o {in_folder(f'runs/{name}_diagram', form)}")
    return Section("Schelling diagrams", (*text, *cautions), tables, fill=(*sweeps_of(missing, AXIS, REWARDS), *fill))


def _rows(contents: Contents, game: str) -> list[tuple[str, ...]]:
    """Returns the rows of a game, first those of the paper's rules, of which the first has what was published; then those of the game as it is."""
    published = published_shape(game)
    note = f" ({published['note']})" if published and published["note"] else ""
    said = f"{published['shape']}, called a {published['type']}{note}" if published else ""
    found = sorted(
        (row for row in contents.evidence.diagrams if row.game == game),
        key=lambda row: (not contents.of_the_paper(row), contents.form(row), row.unit != TRAINED),
    )
    if said and not (found and contents.of_the_paper(found[0])):
        return [(f"{game}, variant {variant(game)}", *("",) * 7, said, ""), *(_row(contents, row, "") for row in found)]
    return [_row(contents, row, said if number == 0 else "") for number, row in enumerate(found)]


def _row(contents: Contents, row: DiagramRow, said: str) -> tuple[str, ...]:
    contrasts = (
        bounded(row.A, row.A_low, row.A_high),
        bounded(row.B, row.B_low, row.B_high),
        bounded(row.fear_mean, row.fear_low, row.fear_high),
        bounded(row.greed_mean, row.greed_low, row.greed_high),
    )
    shape = " and ".join(name for name, there in (("fear", row.fear), ("greed", row.greed)) if there)
    verdict = f"dilemma, {shape}" if row.outcome == "dilemma" else row.outcome
    over = f"{row.units} {row.unit}s" + ("" if row.unit == TRAINED else ", of these policies only")
    return (_label(contents, row), f"`{row.cooperators}`", f"`{row.defectors}`", *contrasts, verdict, said, over)


def _label(contents: Contents, row: DiagramRow) -> str:
    return ", ".join(filter(None, (row.game, contents.form(row))))


def _record(contents: Contents, row: DiagramRow) -> dict[str, Any]:
    published = (published_shape(row.game) if contents.of_the_paper(row) else None) or {}
    return {**vars(row), "published_shape": published.get("shape"), "published_type": published.get("type")}
