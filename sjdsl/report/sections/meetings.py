"""Cross-play: what an agent of a policy earned in each mixture."""

from sjdsl.report.contents import Contents, called, in_folder, sweeps_of
from sjdsl.report.figure_text import bounded
from sjdsl.report.page import Section, Table
from sjdsl.report.sections.own_and_common import AXIS, REWARDS, pools


def meetings(contents: Contents) -> Section:
    """Returns the section of all mixtures that were played."""
    rows = []
    for row in contents.evidence.meetings:
        over = f"{row.units} {row.unit}s" + ("" if row.unit == "training seed" else ", of these policies only")
        rows.append(
            (
                ", ".join(filter(None, (row.game, contents.form(row)))),
                row.mixture,
                f"`{row.policy}`",
                bounded(row.mean, row.low, row.high),
                over,
            )
        )
    of_the_game = any(not contents.form(row) for row in contents.evidence.meetings)
    headings = ("game", "mixture", "policy", "return of an agent", "interval over")
    records = tuple(vars(row) for row in contents.evidence.meetings)
    table = Table("cross_play", "Return of an agent of a policy in a mixture, with its 95 % interval", headings, tuple(rows), records, 3)
    game = next(iter(contents.plain_names), "coins")
    form = contents.wanted_variant(game)
    command = f"sjdsl crossplay {called([game], form)} --policies {' '.join(pools(game, form))} --mix pairs"
    fill = *sweeps_of([(game, form)], AXIS, REWARDS), f"{command} -o {in_folder(f'runs/{game}_pairs', form)}"
    return Section("Cross-play", (), (table,) if rows else (), fill=() if of_the_game else fill)
