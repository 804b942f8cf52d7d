"""The gallery: every bundled game and every substrate of Melting Pot with a moving picture, and a page each with a live board and the rules."""

import posixpath
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import Written, read_written, rule_sheet
from sjdsl.doc.wording import plain
from sjdsl.library.games_folder import find_game, main_games, melting_pot_games
from sjdsl.library.substrates import Substrate, written_substrates
from website.boards import Board
from website.chapters import raised
from website.random_play import random_play, read_figures

FOLDER = "gallery"
BOARDS = "boards"
INDEX = f"{FOLDER}/index.md"
FIGURES = "docs/games.json"
HEAD = """# Gallery

Every bundled game, played by the policies of its own file: cooperators beside defectors, where it has them, else random agents. Choose a
game to step through the episode on a live board, to read its text and all its rules."""
POT = """## Melting Pot

Each substrate of Melting Pot 2 is a game in one of its variants; [what differs]({meltingpot}) is a page of its own."""


@dataclass(frozen=True)
class Shown:
    """A game with a page. name: of the game; written: its rules; boards: the game as it is, then variants that are substrates."""

    name: str
    written: Written
    boards: tuple[Board, ...]

    @property
    def title(self) -> str:
        return plain(self.written.game.title or self.name)

    def title_of(self, board: Board) -> str:
        """Returns the title of the game in a variant, which is a substrate."""
        for substrate in written_substrates():
            if (substrate.game, substrate.variant) == (board.game, board.variant):
                title = substrate_title(substrate, self.title)
                return f"{title} in Melting Pot" if title == self.title else title
        raise LookupError(f"{board.name} is no substrate")

    @property
    def summary(self) -> str:
        return plain(dict(self.written.game.about).get("summary", ""))


def substrate_title(substrate: Substrate, game_title: str) -> str:
    """Returns the title of a substrate: its game's, and which form of the game it is."""
    _, _, form = substrate.name.partition("__")
    if not form or ":" in game_title:
        return game_title
    return f"{game_title}: {form.replace('_', ' ')}"


def shown_names() -> tuple[str, ...]:
    """Returns the names of all bundled games, those of Melting Pot alone last, without reading one."""
    return (*main_games(), *melting_pot_games())


@cache
def shown_games() -> tuple[Shown, ...]:
    """Returns all bundled games, in the order of their names' list."""
    return tuple(_shown(name) for name in shown_names())


def _shown(name: str) -> Shown:
    variants = dict.fromkeys(["", *(s.variant for s in written_substrates() if s.game == name)])
    boards = tuple(
        Board(f"{name}__{variant}" if variant else name, name, variant) for variant in variants
    )
    return Shown(name, read_written(read_source(find_game(name)), ()), boards)


def game_pages(root: Path) -> dict[str, str]:
    """Returns the page of each game by its file in the repository."""
    return {str(find_game(name).relative_to(root)): f"{FOLDER}/{name}.md" for name in shown_names()}


def gallery_page() -> str:
    """Returns the page of all games as Markdown."""
    own, substrates = set(main_games()), written_substrates()
    lines = [HEAD, "", '<div class="grid cards" markdown>', ""]
    for shown in shown_games():
        if shown.name in own:
            lines += _card(shown.title, shown.boards[0], shown.summary)
    lines += [
        "</div>",
        "",
        POT.format(meltingpot="../meltingpot.md"),
        "",
        '<div class="grid cards small" markdown>',
        "",
    ]
    for substrate in substrates:
        shown = next(shown for shown in shown_games() if shown.name == substrate.game)
        board = next(board for board in shown.boards if board.variant == substrate.variant)
        lines += _card(substrate_title(substrate, shown.title), board, "")
    return "\n".join([*lines, "</div>", ""])


def _card(title: str, board: Board, text: str) -> list[str]:
    page = f"{board.game}.md" + (f"#{anchor(board)}" if board.variant else "")
    lines = [f"-   [{picture(board, '..')}]({page})", "", f"    **[{title}]({page})**", ""]
    return [*lines, *([f"    {text}", ""] if text else [])]


def anchor(board: Board) -> str:
    """Returns the anchor of a variant on its game's page."""
    return f"variant-{board.variant}"


def picture(board: Board, up: str) -> str:
    """Returns the moving picture, as HTML; it stands still where the reader's system asks for that. up: the way to the top of the site."""
    place = posixpath.join(up, BOARDS, board.name)
    still = f'<source media="(prefers-reduced-motion: reduce)" srcset="{place}.png">'
    return f'<picture>{still}<img src="{place}.gif" alt="{board.game} {board.variant}" loading="lazy" class="moving"></picture>'


def frame(board: Board, title: str) -> str:
    """Returns the live board, as HTML: a page of its own, which can run its scripts and reach nothing around it, and says how high it is."""
    place = f"../{BOARDS}/{board.name}.html"
    return f'<iframe class="board" src="{place}" title="An episode of {title}" loading="lazy" sandbox="allow-scripts"></iframe>'


def game_page(shown: Shown, root: Path) -> str:
    """Returns the page of a game as Markdown."""
    path = find_game(shown.name)
    text = path.read_text("utf-8")
    first, *others = shown.boards
    board = frame(first, shown.title)
    lines = [f"# {shown.title}", "", shown.summary, "", board, "", _below(first), ""]
    lines += _as_substrates(shown.name, first)
    lines += [
        f'??? example "The file `{path.relative_to(root)}`, {len(text.splitlines())} lines"',
        "",
        "    ``` { .sj }",
    ]
    lines += [f"    {line}".rstrip() for line in text.splitlines()]
    lines += ["    ```", ""]
    variants = dict(shown.written.variants)
    for board in others:
        title = shown.title_of(board)
        lines += [
            f"## {title} {{ #{anchor(board)} }}",
            "",
            f"The variant `{board.variant}`: {variants[board.variant]}.",
            "",
            *_as_substrates(shown.name, board),
            frame(board, title),
            "",
            _below(board),
            "",
        ]
    figures = read_figures(root / FIGURES)
    if shown.name in figures:
        lines += ["## Random play", "", *random_play(figures[shown.name]), ""]
    sheet = rule_sheet(shown.written).split("\n", 1)[1]
    sheet = sheet.replace(f"{shown.summary}\n\n", "", 1)  # the page begins with it
    return "\n".join([*lines, "## The rules", "", raised(sheet, -1)])


def _below(board: Board) -> str:
    variant = f" --variant {board.variant}" if board.variant else ""
    alone = f"[a page of its own](../{BOARDS}/{board.name}.html)"
    return f"The episode is also {alone}; `sjdsl render {board.game}{variant} -o {board.name}.html` makes such a page of any game."


def _as_substrates(name: str, board: Board) -> Sequence[str]:
    names = [
        f"`{s.name}`" for s in written_substrates() if s.game == name and s.variant == board.variant
    ]
    return (
        [f"In [Melting Pot](../meltingpot.md) this is {' and '.join(names)}.", ""] if names else []
    )
