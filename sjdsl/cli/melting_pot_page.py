"""Writes the page of Melting Pot's substrates with its pictures, and finds what of it is not up to date."""

from functools import cache
from pathlib import Path

import click

from sjdsl.cli.game_file import open_game, split_variants
from sjdsl.cli.page_text import write_text
from sjdsl.compiler import Build, build, ir
from sjdsl.doc.figures import is_picture_of
from sjdsl.doc.melting_pot import PICTURES, draw_start, melting_pot_page
from sjdsl.substrates import Substrate, substrates, written_substrates

PAGE = Path("docs/meltingpot.md")


@cache
def build_of(s: Substrate) -> Build:
    """Returns a written substrate built, with its warnings; once in a process. Raises CompileError."""
    return build(open_game(s.game), split_variants(s.variant))


def read_rules() -> dict[str, ir.Game]:
    """Returns the rules of the substrates that have been written, by name. Raises CompileError."""
    return {s.name: build_of(s).game for s in written_substrates()}


def make_melting_pot_page(path: Path, fresh: bool) -> None:
    """Writes the page and its pictures; a picture of unchanged rules is kept unless `fresh`."""
    rules = read_rules()
    for s in written_substrates():
        picture = path.parent / PICTURES / f"{s.name}.png"
        if fresh or not picture.is_file() or not is_picture_of(picture, rules[s.name]):
            draw_start(s, picture)
    text = melting_pot_page(list(substrates().values()), rules)
    write_text(path, text)
    click.echo(f"{path}  {len(rules)} of {len(substrates())} substrates, {len(text.splitlines())} lines")


def melting_pot_problems(path: Path) -> list[str]:
    """Returns what is not up to date: the text, and pictures that are missing, of other rules, or of no substrate."""
    rules = read_rules()
    wanted = {path.parent / PICTURES / f"{name}.png": game for name, game in rules.items()}
    there = set((path.parent / PICTURES).glob("*.png"))
    found = [f"{picture}: missing" for picture in sorted(wanted.keys() - there)]
    found += [f"{picture}: of no substrate" for picture in sorted(there - wanted.keys())]
    found += [f"{p}: of other rules or looks" for p in sorted(wanted.keys() & there) if not is_picture_of(p, wanted[p])]
    if not path.is_file() or path.read_text(encoding="utf-8") != melting_pot_page(list(substrates().values()), rules):
        found.append(f"{path}: not what the table of substrates says")
    return found
