"""Table of the differences between observations in the variant `socialjax` and in the released SocialJax suite."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.lower import token_planes
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc.wording import code, plain, table
from sjdsl.doc.written import read_written
from sjdsl.games_folder import find_game
from sjdsl.interop.socialjax_table import NOT_HERE, Entry, channels_of, differences, entries
from sjdsl.runtime.planes import channel_names

VARIANT = "socialjax"
HEADINGS = ("agent: self", "agent: other same heading", "agent: other turned right", "agent: other opposite", "agent: other turned left")
OWN_HEADING = tuple(f"agent.heading: {way}" for way in ("north", "east", "south", "west"))  # in the table's row on windows
INTRODUCTION = """Each game of the paper has a variant `socialjax` with the rules and the observation of the released code. Things that look alike
to its agents look alike here too. This table lists all remaining differences. Its first rows are found by comparing the channels."""
Row = tuple[str, str, str, str]


def released_section() -> list[str]:
    """Returns the section of the page."""
    rows = [row for theirs, entry in entries().items() for row in _of_channels(theirs, entry)]
    for difference in differences():
        for theirs in difference.games or ("all",):
            rows.append((theirs, difference.what, difference.there, difference.here))
    together: dict[tuple[str, str, str], list[str]] = {}
    for theirs, *row in rows:
        together.setdefault((row[0], row[1], row[2]), []).append(theirs)
    found = [("all" if games == ["all"] else ", ".join(map(_ours, games)), *map(plain, row)) for row, games in together.items()]
    heading = ['<a id="released"></a>', "", "## How observations in the released suite differ", "", INTRODUCTION, ""]
    return [*heading, *table(("game", "what", "released", "here"), found), ""]


def _ours(theirs: str) -> str:
    return code(entries()[theirs].game)


def _of_channels(theirs: str, entry: Entry) -> Iterator[Row]:
    """Yields what one of the two shows in some channel and the other in none."""
    for source in dict.fromkeys(s for s in [*entry.tiles, *entry.rest] if isinstance(s, str)):
        if source.startswith(NOT_HERE):
            yield theirs, source.removeprefix(NOT_HERE), "shown", "not shown"
    for name in unread(entry, released_game(entry.game)):
        yield theirs, name, "not shown", "shown"


def released_game(name: str) -> ir.Game:
    """Returns the rules of a game as released."""
    return read_written(read_source(find_game(name)), (VARIANT,)).game


def unread(entry: Entry, game: ir.Game) -> list[str]:
    """Returns our channels that say more than the released ones."""
    read = {name for source in [*entry.tiles, *entry.rest] for name in channels_of(source, game.agents.number)}
    read |= {name for layer in entry.layers for name in layer}
    known = {*read, *HEADINGS, *OWN_HEADING, "agent: none", *(f"content: {look}" for look in entry.plain)}
    return [name for name in channel_names(token_planes(game)) if name not in known]
