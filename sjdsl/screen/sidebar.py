"""The text beside the map: step, actions and rewards of the agents, legend, and keys."""

from collections.abc import Mapping, Sequence

import numpy as np
from rich.columns import Columns
from rich.style import Style
from rich.table import Column, Table
from rich.text import Text

from sjdsl.render.appearance import draw_figures
from sjdsl.render.colours import hexadecimal
from sjdsl.render.legend import mark_text
from sjdsl.render.moment import Moment
from sjdsl.screen.board import OWN, ScreenLooks, figure_letters, inked, letter_of
from sjdsl.screen.keys import describe_keys


def score_table(actions: Sequence[str], looks: ScreenLooks, moment: Moment, own: int | None) -> Table:
    """Returns a line for each agent: what it did in the last step, what it got for it, what it has got so far."""
    heads = ("agent", "did", Column("reward", justify="right"), Column("return", justify="right"))
    table = Table(*heads, box=None, padding=(0, 1, 0, 0), show_edge=False, header_style="dim")
    snapshot = moment.snapshot
    for number, figure in enumerate(draw_figures(looks.look, snapshot)["agent"]):
        state = " away" if snapshot.row[number] < 0 else " you" if number == own else " held" if figure.held else ""
        did = actions[moment.actions[number]] if moment.actions else ""
        reward = float(moment.reward[number])
        paid = Text(f"{reward:+.4g}", "bold green" if reward > 0 else "bold red") if reward else ""
        table.add_row(
            Text().append(*figure_letters(looks, "agent", figure, own)).append(state), did, paid, f"{snapshot.returns[number]:.4g}"
        )
    return table


def event_line(moment: Moment) -> str:
    """Returns what was tallied in the last step, summed over agents."""
    totals = {name: np.sum(count) for name, count in moment.events.items()}
    return ", ".join(f"{name} {total}" for name, total in totals.items() if total)


def legend(looks: ScreenLooks, own: int | None) -> Text:
    """Returns what each letter and colour of the map stands for, a line each."""
    lines = []
    for (kind, state), (ground, _) in looks.tiles.items():
        lines.append(Text().append(f"{looks.letters.characters[kind, state]} ", inked(ground)).append(f" {', '.join((kind, *state))}"))
    for label, colour in looks.marks.items():
        lines.append(
            Text().append("  ", Style(bgcolor=hexadecimal(colour))).append(f" cells that `{mark_text(looks.look, label)}` reaches")
        )
    lines.append(Text("▲0").append(" an agent that faces up; pale: can only stay"))
    if own is not None:
        lines.append(Text().append(f"▲{letter_of(own)}", inked(OWN) + Style(bold=True)).append(" the agent you steer"))
    for herd in looks.look.herds:
        style = inked(looks.bodies[herd.name, herd.colour])
        lines.append(Text().append(f"▲{herd.glyph}", style).append(f" {herd.name} that faces up"))
    for fields, what in ((looks.owners, "the owner"), (looks.amounts, "how much")):
        if fields:
            kinds = " and ".join(f"{kind} ({field})" for kind, field in fields.items())
            lines.append(Text(f"a number beside {kinds}: {what}"))
    return Text("\n").join(lines)


def key_line(keys: Mapping[str, int] | None, action_names: Sequence[str]) -> Columns:
    """Returns what the keys do. `keys`: of the agent that is steered; None where all is watched."""
    said = [("space", "pause"), ("→", "one step")] if keys is None else describe_keys(dict(keys), action_names)
    return Columns([Text().append(key, "bold").append(f" {what}") for key, what in [*said, ("q", "quit")]], padding=(0, 2))
