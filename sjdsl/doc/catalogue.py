"""The page of the bundled games: for each a picture, a summary, its parameters, and the returns of a random policy."""

from collections.abc import Sequence
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.doc.actions import action_names
from sjdsl.doc.figures import Figure, Figures
from sjdsl.doc.numbers import parameters
from sjdsl.doc.released import released_section
from sjdsl.doc.wording import code, codes, number, plain, table
from sjdsl.doc.written import Written

PICTURES = "pictures"
INTRODUCTION = """These games come with sjdsl. Each is a text of about eighty lines in [games/](../games), and this page is generated from them with
`make docs` (or `sjdsl doc --all`). `sjdsl doc GAME` prints all the rules of a game in plain English, and `sjdsl diff GAME --variants A B`
prints what a variant changes. The further families of Melting Pot have a page of their own, [meltingpot.md](meltingpot.md).

Paradigm, long term impact, multi task and difficulty are those of the SocialJax paper (ICLR 2026), for the games it has. Columns that begin
with `our` are our own judgement. A comment beside the line in the game gives the reason."""
OURS = "our_"


@dataclass(frozen=True)
class Entry:
    """A bundled game with the figures of a random policy, if they have been measured."""

    name: str
    written: Written
    figures: Figures | None


def catalogue(entries: Sequence[Entry]) -> str:
    """Returns the page as Markdown: all games, each game, and what the released suite shows otherwise."""
    said = dict.fromkeys(key for e in entries for key, _ in e.written.game.about if key != "summary")
    keys = sorted(said, key=lambda key: key.startswith(OURS))
    head = ("game", "agents", "map", "actions", *(key.replace("_", " ") for key in keys))
    overview = table(head, [_row(e, keys) for e in entries])
    lines = ["# The games", "", INTRODUCTION, "", *overview, ""]
    for entry in entries:
        lines += _game(entry)
    lines += released_section()
    return "\n".join(lines).rstrip("\n") + "\n"


def _row(e: Entry, keys: Sequence[str]) -> tuple[str, ...]:
    game, about = e.written.game, dict(e.written.game.about)
    return (
        f"[{plain(game.title)}](#{e.name})",
        str(game.agents.number),
        _size(game),
        str(len(game.agents.actions)),
        *(plain(about.get(k, "")) for k in keys),
    )


def _size(game: ir.Game) -> str:
    return f"{len(game.rows)} × {len(game.rows[0])}"


def _game(e: Entry) -> list[str]:
    game = e.written.game
    summary = dict(game.about).get("summary", "")
    lines = [f'<a id="{e.name}"></a>', "", f"## {plain(game.title)}", "", f"![{plain(game.title)}]({PICTURES}/{e.name}.png)", ""]
    lines += [plain(summary), ""] if summary else []
    lines += [*_facts(e), "", "Numbers:", "", *parameters(e.written)]
    return [*lines, *(_figures(e.figures) if e.figures is not None else ["The returns of a random policy have not been measured.", ""])]


def _facts(e: Entry) -> list[str]:
    game = e.written.game
    rows = [
        ("agents", str(game.agents.number)),
        ("map", f"{len(game.rows)} rows of {len(game.rows[0])} cells" + (", edges joined" if game.wraps else "")),
        ("actions", codes(action_names(game.agents))),
        ("window", _window(game.window)),
        *((key.replace("_", " "), plain(text)) for key, text in game.about if key != "summary"),
        ("sources", "; ".join(map(plain, game.cites))),
        ("all the rules", code(f"sjdsl doc {e.name}")),
    ]
    rows += [(f"variant {code(name)}", plain(title)) for name, title in e.written.variants]
    return table(("", ""), [row for row in rows if row[1]])


def _window(window: ir.Window) -> str:
    """Returns how far agents see; of several windows each, the usual one first."""
    sides = [f"{x.ahead} ahead, {x.behind} behind, {x.left} left, {x.right} right" for x in (window.views or (window,))[::-1]]
    return sides[0] + "".join(f"; of some agents {other}" for other in sides[1:])


def _figures(f: Figures) -> list[str]:
    title = f"A random policy, {f.episodes} episodes from seed {f.seed}, means with their 95 % confidence intervals:"
    return [title, "", *table(("", "mean", "interval"), [(name, *_figure(figure)) for name, figure in f.values.items()]), ""]


def _figure(figure: Figure) -> tuple[str, str]:
    if figure.mean is None or figure.low is None or figure.high is None:
        return "not defined", "some returns are negative, or all are 0"
    return _short(figure.mean), f"{_short(figure.low)} to {_short(figure.high)}"


def _short(value: float) -> str:
    """Returns four significant digits."""
    return number(float(f"{value:.4g}"))
