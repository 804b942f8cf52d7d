"""The text beside the map: step, actions and rewards of the agents, legend, and keys."""

from collections.abc import Iterator, Mapping, Sequence

from rich.columns import Columns
from rich.style import Style
from rich.table import Column, Table
from rich.text import Text

from sjdsl.compiler import ir
from sjdsl.screen.board import agent_letters, hexadecimal, mover_style
from sjdsl.screen.display import Display
from sjdsl.screen.keys import describe_keys
from sjdsl.screen.looks import OWN, ScreenLooks, letter_of
from sjdsl.screen.palette import ink_on


def score_table(game: ir.Game, looks: ScreenLooks, display: Display, own: int | None) -> Table:
    """Returns a line for each agent: what it did in the last step, what it got for it, what it has got so far."""
    heads = ("agent", "did", Column("reward", justify="right"), Column("return", justify="right"))
    table = Table(*heads, box=None, padding=(0, 1, 0, 0), show_edge=False, header_style="dim")
    for number in range(game.agents.number):
        who = Text().append(*agent_letters(looks, display.world, number, own, number in display.held))
        who.append(_standing(display, number, own))
        did = game.agents.actions[display.actions[number]] if display.actions else ""
        reward, style = display.rewards[number], "bold green" if display.rewards[number] > 0 else "bold red"
        table.add_row(who, did, Text(f"{reward:+.4g}", style) if reward else "", f"{display.returns[number]:.4g}")
    return table


def _standing(display: Display, number: int, own: int | None) -> str:
    if display.world.position[number] is None:
        return " away"
    return " you" if number == own else " held" if number in display.held else ""


def event_line(display: Display) -> str:
    """Returns what was tallied in the last step."""
    return ", ".join(f"{name} {count}" for name, count in display.events.items())


def legend(looks: ScreenLooks, own: int | None) -> Text:
    """Returns what each letter and colour of the map stands for, a line each."""
    lines = [Text().append(*swatch).append(f" {meaning}") for swatch, meaning in _entries(looks)]
    lines.append(Text("▲0").append(" an agent that faces up; pale: can only stay"))
    if own is not None:
        mine = Style(color=hexadecimal(ink_on(OWN)), bgcolor=hexadecimal(OWN), bold=True)
        lines.append(Text().append(f"▲{letter_of(own)}", mine).append(" the agent you steer"))
    for sort, letter in looks.letters.movers.items():
        lines.append(Text().append(f"▲{letter}", mover_style(looks, sort)).append(f" {sort} that faces up"))
    if looks.owners:
        lines.append(Text(f"a number beside {_joined(looks.owners)}: the owner"))
    if looks.amounts:
        lines.append(Text(f"a number beside {_joined(looks.amounts)}: how much"))
    return Text("\n").join(lines)


def _entries(looks: ScreenLooks) -> Iterator[tuple[tuple[str, Style], str]]:
    for (kind, state), (ground, _) in looks.tiles.items():
        words = ", ".join(str(word) for _, word in state)
        letter = looks.letters.characters[kind, state]
        yield (f"{letter} ", Style(color=hexadecimal(ink_on(ground)), bgcolor=hexadecimal(ground))), f"{kind}, {words}" if words else kind
    for label, colour in looks.marks.values():
        yield ("  ", Style(bgcolor=hexadecimal(colour))), f"cells that `{label}` reaches"


def _joined(kinds: Mapping[str, str]) -> str:
    return " and ".join(f"{kind} ({field})" for kind, field in kinds.items())


def key_line(keys: Mapping[str, int] | None, action_names: Sequence[str]) -> Columns:
    """Returns what the keys do. `keys`: of the agent that is steered; None where all is watched."""
    said = [("space", "pause"), ("→", "one step")] if keys is None else describe_keys(dict(keys), action_names)
    return Columns([Text().append(key, "bold").append(f" {what}") for key, what in [*said, ("q", "quit")]], padding=(0, 2))
