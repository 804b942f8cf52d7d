"""Writes the page of the games of `games/` itself: its text, figures and pictures."""

from pathlib import Path

import click

from sjdsl.cli.game_file import open_game
from sjdsl.cli.page_text import write_text
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.doc import read_written
from sjdsl.doc.catalogue import PICTURES, Entry, catalogue
from sjdsl.doc.figures import draw_picture, figures_text, is_picture_of, measure, read_figures
from sjdsl.games_folder import main_games

PAGE = Path("docs/games.md")


def make_page(path: Path, fresh: bool) -> None:
    """Writes the page, its figures (`.json` beside it) and pictures; what belongs to unchanged rules is kept unless `fresh`."""

    kept = {} if fresh else read_figures(path.with_suffix(".json"))
    entries = []
    for name in main_games():
        written = read_written(open_game(name))
        picture = path.parent / PICTURES / f"{name}.png"
        figures = kept.get(name)
        if figures is None or figures.hash != game_hash(written.game):
            click.echo(f"{name}: measuring")
            figures = measure(name)
            draw_picture(name, picture)
        elif not picture.is_file() or not is_picture_of(picture, written.game):
            draw_picture(name, picture)
        entries.append(Entry(name, written, figures))
    text = catalogue(entries)
    write_text(path.with_suffix(".json"), figures_text({e.name: e.figures for e in entries if e.figures is not None}))
    write_text(path, text)
    click.echo(f"{path}  {len(entries)} games, {len(text.splitlines())} lines")


def page_problems(path: Path) -> list[str]:
    """Returns what is not up to date: the text, figures of other rules, pictures that are missing or belong to no game."""

    kept = read_figures(path.with_suffix(".json"))
    entries = [Entry(name, read_written(open_game(name)), kept.get(name)) for name in main_games()]
    found = []
    for entry in entries:
        if entry.figures is None:
            found.append(f"{entry.name}: no figures")
        elif entry.figures.hash != game_hash(entry.written.game):
            found.append(f"{entry.name}: the figures are of other rules")
    wanted = {path.parent / PICTURES / f"{entry.name}.png" for entry in entries}
    there = set((path.parent / PICTURES).glob("*.png"))
    drawn = {path.parent / PICTURES / f"{entry.name}.png": entry.written.game for entry in entries}
    found += [f"{picture}: of other rules or looks" for picture in sorted(wanted & there) if not is_picture_of(picture, drawn[picture])]
    found += [f"{picture}: missing" for picture in sorted(wanted - there)]
    found += [f"{picture}: of no game" for picture in sorted(there - wanted)]
    found += [f"{name}: figures of no game" for name in kept if name not in {entry.name for entry in entries}]
    if not path.is_file() or path.read_text(encoding="utf-8") != catalogue(entries):
        found.append(f"{path}: not what the games say")
    return found
