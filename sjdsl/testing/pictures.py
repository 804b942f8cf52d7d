"""Pictures of a map for tests: rows of characters, agents as arrows, their numbers beside a row, movers by the character of their sort."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import Cell, World
from sjdsl.render.letters import with_figures
from sjdsl.render.moment import snapshot_of
from sjdsl.testing.signs import Signs

Pose = tuple[int, int, int]  # row, column, heading


@dataclass(frozen=True)
class Row:
    """One row of a picture: its signs, and the numbers of its agents from left to right if they are told."""

    signs: str
    numbers: tuple[int, ...] | None

    def __str__(self) -> str:
        if not self.numbers:
            return self.signs
        join = "" if max(self.numbers) < 10 else ","
        return f"{self.signs}  {join.join(map(str, self.numbers))}"


def read_picture(picture: Sequence[str], signs: Signs) -> list[Row]:
    """Returns the rows of a picture as written, as in `"..>.<  10"`; numbers above 9 are parted by commas.

    Raises ValueError: a picture that does not fit the map, or numbers that do not fit the arrows.
    """
    rows, size = signs.game.rows, (len(signs.game.rows), len(signs.game.rows[0]))
    if len(picture) != size[0]:
        raise ValueError(f"the picture has {len(picture)} rows, the map has {size[0]}")
    read = []
    for r, text in enumerate(picture):
        cells, *beside = text.split() or [""]
        if len(cells) != size[1]:
            raise ValueError(
                f"row {r} of the picture has {len(cells)} cells, the map has {size[1]}: `{text}`"
            )
        for c, sign in enumerate(cells):
            _check(sign, rows[r][c], f"row {r}, column {c}", signs)
        arrows = sum(sign in signs.arrows for sign in cells)
        read.append(Row(cells, _numbers(" ".join(beside), arrows, r) if beside else None))
    return read


def _check(sign: str, glyph: str, where: str, signs: Signs) -> None:
    if signs.stands(sign):
        return
    kind = signs.by_character[glyph].kind
    if sign not in signs.by_character:
        known = ", ".join(f"`{c}` {s}" for c, s in signs.by_character.items() if s.kind == kind)
        raise ValueError(
            f"{where}: `{sign}` isn't a sign; the map has a `{kind}` there: {known}; add others with `looks`"
        )
    if signs.by_character[sign].kind != kind:
        raise ValueError(
            f"{where}: `{sign}` stands for `{signs.by_character[sign].kind}`, and the map has `{kind}` there"
        )


def _numbers(text: str, arrows: int, row: int) -> tuple[int, ...]:
    parts = list(text) if len(text) == arrows else re.split(r"[,\s]+", text.strip())
    if len(parts) != arrows or not all(
        part.isdecimal() and part == str(int(part)) for part in parts
    ):
        raise ValueError(
            f"row {row} has {arrows} agents; beside it `{text}` does not number them (numbers above 9 with commas: `3,12`)"
        )
    return tuple(map(int, parts))


def numbered(
    rows: Sequence[Row], signs: Signs, agents: int, away: Collection[int]
) -> dict[int, Pose]:
    """Returns the pose of each agent of a picture by its number: as told beside its row, the others in reading order.

    Raises ValueError: an agent that is missing, twice in the picture, or one too many.
    """
    told = [number for row in rows for number in row.numbers or ()]
    free = [number for number in range(agents) if number not in told and number not in away]
    poses: dict[int, Pose] = {}
    count = 0
    for r, row in enumerate(rows):
        arrows = [
            (r, c, signs.arrows.index(sign))
            for c, sign in enumerate(row.signs)
            if sign in signs.arrows
        ]
        numbers = (
            row.numbers
            if row.numbers is not None
            else [free.pop(0) if free else -1 for _ in arrows]
        )
        poses |= dict(zip(numbers, arrows, strict=True))
        count += len(arrows)
    here = [number for number in range(agents) if number not in away]
    if sorted(poses) != here or count != len(here):
        away_too = f" and {len(away)} away" if away else ""
        raise ValueError(
            f"the game has {agents} agents{away_too}; the picture has {count} arrows"
            + (f", told {told}" if told else "")
        )
    return poses


def placed(
    rows: Sequence[Row],
    signs: Signs,
    numbers: Mapping[str, Sequence[int]],
    away: Mapping[str, Collection[int]],
) -> dict[str, list[Cell | None]]:
    """Returns where the movers of each sort stand in a picture, by their numbers; None for those that are away.

    numbers: of those in the picture, in reading order; else they rise.
    Raises ValueError: more of a sort, or fewer, than are there, or numbers that are not theirs.
    """
    found: dict[str, list[Cell]] = {sort.name: [] for sort in signs.game.movers}
    for r, row in enumerate(rows):
        for c, sign in enumerate(row.signs):
            if sign in signs.movers:
                found[signs.movers[sign]].append(Cell(r, c))
    places: dict[str, list[Cell | None]] = {}
    for sort in signs.game.movers:
        name, gone = sort.name, away.get(sort.name, ())
        here = [number for number in range(sort.number) if number not in gone]
        if unknown := [number for number in gone if number not in range(sort.number)]:
            raise ValueError(
                f"there is no `{name}` {unknown[0]}: the game has {sort.number} movers `{name}`, numbered from 0"
            )
        if len(found[name]) != len(here):
            also = f" and {len(gone)} away" if gone else ""
            raise ValueError(
                f"the game has {sort.number} movers `{name}`{also}; the picture has {len(found[name])} `{sort.glyph}`"
            )
        told = list(numbers.get(name, here))
        if sorted(told) != here:
            raise ValueError(
                f"the numbers of the movers `{name}` in the picture are {here} in some order, not {told}"
            )
        places[name] = [
            found[name][told.index(number)] if number in told else None
            for number in range(sort.number)
        ]
    return places


def put_picture(
    rows: Sequence[Row],
    poses: Mapping[int, Pose],
    under: Mapping[int, str],
    signs: Signs,
    board: Board,
    world: World,
) -> None:
    """Sets the cells of a world as a picture shows them. `under`: signs of what agents stand on; else it is as on the map."""
    below = {poses[agent][:2]: sign for agent, sign in under.items() if agent in poses}
    for agent, sign in under.items():
        if agent not in poses or len(sign) != 1:
            raise ValueError(f"under: one sign for an agent of the picture, not {agent}: {sign!r}")
        row, column, _ = poses[agent]
        _check(sign, board.game.rows[row][column], f"under agent {agent}", signs)
    for cell, kind in board.kind_of.items():
        glyph, sign = board.game.rows[cell.row][cell.col], rows[cell.row].signs[cell.col]
        shown = below.get((cell.row, cell.col), glyph) if signs.stands(sign) else sign
        for name, value in signs.meaning(shown, glyph).items():
            world.cells[kind, name][board.number[cell]] = value


def draw_cells(signs: Signs, board: Board, world: World) -> list[list[str]]:
    """Returns the signs of all cells, without the agents on them."""
    grid = [list(row) for row in board.game.rows]
    told = {kind.name: signs.told(kind.name) for kind in board.game.kinds}
    for cell, kind in board.kind_of.items():
        here: dict[str, Any] = {
            name: world.cells[kind, name][board.number[cell]] for name in told[kind]
        }
        grid[cell.row][cell.col] = signs.draw(kind, here)
    return grid


def draw_picture(signs: Signs, board: Board, world: World) -> list[Row]:
    """Returns the map as it is now, movers and agents over it, all numbers told."""
    movers = {sort: character for character, sort in signs.movers.items()}
    return [
        Row(*line)
        for line in with_figures(
            draw_cells(signs, board, world),
            snapshot_of(board.game, world, ()),
            movers,
            signs.arrows,
        )
    ]


def compare_pictures(wanted: Sequence[Row], found: Sequence[Row]) -> str | None:
    """Returns both pictures one above the other if they differ, the rows that do marked; numbers count where they are wanted."""
    differ = [
        w.signs != f.signs or (w.numbers is not None and w.numbers != f.numbers)
        for w, f in zip(wanted, found, strict=True)
    ]
    if not any(differ):
        return None
    width = max(len(str(row)) for row in (*wanted, *found))
    lines = []
    for title, rows in (("expected", wanted), ("found", found)):
        lines.append(f"{title}:")
        lines += [
            f"  {row!s:{width}}  <- row {r}" if differ[r] else f"  {row}"
            for r, row in enumerate(rows)
        ]
    return "\n".join(lines)
