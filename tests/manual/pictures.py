"""Maps as the manual draws them: glyphs of cells, agents over them as arrows."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

from sjdsl.compiler import ir

from .plays import HEADINGS, Picture, Place, View

ARROWS = dict(zip("^>v<", HEADINGS, strict=True))


def places_of(game: ir.Game) -> Iterator[tuple[int, int, str, int]]:
    """Yields the row and column of each cell, its kind, and the number of the cell among those of its kind."""
    number: Counter[str] = Counter()
    for r, row in enumerate(game.rows):
        for c, glyph in enumerate(row):
            kind = kind_of(game, glyph)
            yield r, c, kind, number[kind]
            number[kind] += 1


def draw(game: ir.Game, view: View) -> list[str]:
    """Returns the rows of the map as they look now; a cell in a state without a glyph has its kind's own."""
    arrows = {place: arrow for arrow, h in ARROWS.items() for place, heading in zip(view.places, view.heading, strict=True) if h == heading}
    arrows |= {place: sort.glyph for sort in game.movers for place in view.herds[sort.name] if place is not None}
    rows = [""] * len(game.rows)
    for r, c, kind, index in places_of(game):
        here = {name: values[index] for (k, name), values in view.cells.items() if k == kind}
        rows[r] += arrows.get((r, c)) or glyph_of(game, kind, here)
    return rows


def read(game: ir.Game, rows: list[str], view: View) -> Picture:
    """Returns what a picture shows; of the fields of cells, those that its glyphs speak of."""
    assert [len(r) for r in rows] == [len(r) for r in game.rows], "the picture is not as large as the map"
    places: list[Place] = []
    heading: list[str] = []
    herds: dict[str, list[Place]] = {sort.name: [] for sort in game.movers}
    sorts = {sort.glyph: sort.name for sort in game.movers}
    told = {(g.kind, name) for g in game.glyphs for name in meaning(game, g.glyph)}
    cells = {key: list(values) for key, values in view.cells.items() if key in told}
    for r, c, kind, index in places_of(game):
        glyph = rows[r][c]
        if glyph in ARROWS:
            places.append((r, c))
            heading.append(ARROWS[glyph])
        elif glyph in sorts:
            herds[sorts[glyph]].append((r, c))
        else:
            assert kind_of(game, glyph) == kind, f"row {r}, column {c}: the map has no `{glyph}` there"
            for name, value in meaning(game, glyph).items():
                cells[kind, name][index] = value
    assert len(places) == game.agents.number, f"{len(places)} agents in the picture, not {game.agents.number}"
    assert all(len(herds[sort.name]) == sort.number for sort in game.movers), f"the picture has the movers {herds}"
    return Picture(places, heading, cells, herds)


def kind_of(game: ir.Game, glyph: str) -> str:
    return next(g.kind for g in game.glyphs if g.glyph == glyph)


def meaning(game: ir.Game, glyph: str) -> dict[str, Any]:
    """Returns the values a glyph stands for, of the fields that tell the kind's glyphs apart."""
    shown = next(g for g in game.glyphs if g.glyph == glyph)
    kind = next(k for k in game.kinds if k.name == shown.kind)
    told = {name for g in game.glyphs if g.kind == shown.kind for name, _ in g.starts}
    return {f.name: f.start for f in kind.fields if f.name in told} | dict(shown.starts)


def glyph_of(game: ir.Game, kind: str, here: dict[str, Any]) -> str:
    glyphs = [g.glyph for g in game.glyphs if g.kind == kind]
    fitting = [g for g in glyphs if all(here[name] == value for name, value in meaning(game, g).items())]
    return (fitting or glyphs)[0]
