"""Pictures of a map for tests.

Rows of characters, agents as arrows with their numbers beside the row, movers as the glyph of their
entity type.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import Cell, World
from sjdsl.render.letters import with_figures
from sjdsl.render.moment import snapshot_of
from sjdsl.testing.signs import Signs

Pose = tuple[int, int, int]  # row, column, heading


@dataclass(frozen=True)
class Row:
    """One row of a picture.

    Its signs, and the numbers of its agents from left to right, or None.
    """

    signs: str
    numbers: tuple[int, ...] | None

    def __str__(self) -> str:
        if not self.numbers:
            return self.signs
        separator = "" if max(self.numbers) < 10 else ","
        return f"{self.signs}  {separator.join(map(str, self.numbers))}"


def read_picture(picture: Sequence[str], signs: Signs) -> list[Row]:
    """Returns the rows of a picture, as in `"..>.<  10"`; numbers above 9 are separated by commas.

    Raises ValueError: a picture that does not fit the map, or numbers that do not fit the arrows.
    """
    glyph_rows = signs.game.rows
    height = len(glyph_rows)
    width = len(glyph_rows[0])
    if len(picture) != height:
        raise ValueError(f"the picture has {len(picture)} rows, the map has {height}")
    rows = []
    for row, text in enumerate(picture):
        cells, *numbers = text.split() or [""]
        if len(cells) != width:
            raise ValueError(
                f"row {row} of the picture has {len(cells)} cells, the map has {width}: `{text}`"
            )
        for col, sign in enumerate(cells):
            _check(sign, glyph_rows[row][col], f"row {row}, column {col}", signs)
        arrows = sum(sign in signs.arrows for sign in cells)
        rows.append(Row(cells, _numbers(" ".join(numbers), arrows, row) if numbers else None))
    return rows


def _check(sign: str, glyph: str, where: str, signs: Signs) -> None:
    """Raises ValueError unless a sign can be drawn where the map has a glyph."""
    if signs.is_body(sign):
        return
    kind = signs.by_character[glyph].kind
    if sign not in signs.by_character:
        of_kind = [f"`{c}` {s}" for c, s in signs.by_character.items() if s.kind == kind]
        raise ValueError(
            f"{where}: `{sign}` isn't a sign; the map has a `{kind}` there: {', '.join(of_kind)}; "
            "add others with `looks`"
        )
    if signs.by_character[sign].kind != kind:
        raise ValueError(
            f"{where}: `{sign}` stands for `{signs.by_character[sign].kind}`, "
            f"and the map has `{kind}` there"
        )


def _numbers(text: str, arrows: int, row: int) -> tuple[int, ...]:
    """Returns the numbers beside a row, one for each of its arrows. Raises ValueError."""
    parts = list(text) if len(text) == arrows else re.split(r"[,\s]+", text.strip())
    are_numbers = all(part.isdecimal() and part == str(int(part)) for part in parts)
    if len(parts) != arrows or not are_numbers:
        raise ValueError(
            f"row {row} has {arrows} agents; beside it `{text}` does not number them "
            "(numbers above 9 with commas: `3,12`)"
        )
    return tuple(map(int, parts))


def read_poses(
    rows: Sequence[Row], signs: Signs, agents: int, away: Collection[int]
) -> dict[int, Pose]:
    """Returns the pose of each agent of a picture by its number.

    Agents without a number beside their row have the other numbers in reading order.

    Raises ValueError: an agent that is missing, twice in the picture, or one too many.
    """
    written = [number for row in rows for number in row.numbers or ()]
    present = [number for number in range(agents) if number not in away]
    unused = iter([number for number in present if number not in written])
    poses: dict[int, Pose] = {}
    count = 0
    for row_index, row in enumerate(rows):
        arrows = [
            (row_index, col, signs.arrows.index(sign))
            for col, sign in enumerate(row.signs)
            if sign in signs.arrows
        ]
        numbers = row.numbers
        if numbers is None:
            numbers = tuple(next(unused, -1) for _ in arrows)
        poses |= dict(zip(numbers, arrows, strict=True))
        count += len(arrows)
    if sorted(poses) != present or count != len(present):
        and_away = f" and {len(away)} away" if away else ""
        with_numbers = f", told {written}" if written else ""
        raise ValueError(
            f"the game has {agents} agents{and_away}; the picture has {count} arrows{with_numbers}"
        )
    return poses


def read_mover_cells(
    rows: Sequence[Row],
    signs: Signs,
    numbers: Mapping[str, Sequence[int]],
    away: Mapping[str, Collection[int]],
) -> dict[str, list[Cell | None]]:
    """Returns entity type -> the cells of its movers by number, None for those that are away.

    Args:
      numbers: those of the movers in the picture, in reading order; by default they rise.

    Raises:
      ValueError: there are more or fewer movers than in the game, or the numbers don't fit.
    """
    cells: dict[str, list[Cell]] = {movers.name: [] for movers in signs.game.movers}
    for row_index, row in enumerate(rows):
        for col, sign in enumerate(row.signs):
            if sign in signs.movers:
                cells[signs.movers[sign]].append(Cell(row_index, col))
    places: dict[str, list[Cell | None]] = {}
    for movers in signs.game.movers:
        name = movers.name
        absent = away.get(name, ())
        for number in absent:
            if number not in range(movers.number):
                raise ValueError(
                    f"there is no `{name}` {number}: the game has {movers.number} movers `{name}`, "
                    "numbered from 0"
                )
        present = [number for number in range(movers.number) if number not in absent]
        if len(cells[name]) != len(present):
            and_away = f" and {len(absent)} away" if absent else ""
            raise ValueError(
                f"the game has {movers.number} movers `{name}`{and_away}; "
                f"the picture has {len(cells[name])} `{movers.glyph}`"
            )
        order = list(numbers.get(name, present))
        if sorted(order) != present:
            raise ValueError(
                f"the numbers of the movers `{name}` in the picture are {present} in some order, "
                f"not {order}"
            )
        by_number = dict(zip(order, cells[name], strict=True))
        places[name] = [by_number.get(number) for number in range(movers.number)]
    return places


def put_picture(
    rows: Sequence[Row],
    poses: Mapping[int, Pose],
    under: Mapping[int, str],
    signs: Signs,
    board: Board,
    world: World,
) -> None:
    """Sets the cells of a world as a picture shows them.

    `under` has the sign of the cell under an agent; by default that cell is as on the map.
    """
    sign_under = {}  # by (row, column)
    for agent, sign in under.items():
        if agent not in poses or len(sign) != 1:
            raise ValueError(f"under: one sign for an agent of the picture, not {agent}: {sign!r}")
        row, col, _ = poses[agent]
        _check(sign, board.game.rows[row][col], f"under agent {agent}", signs)
        sign_under[row, col] = sign
    for cell, kind in board.kind_of.items():
        glyph = board.game.rows[cell.row][cell.col]
        sign = rows[cell.row].signs[cell.col]
        if signs.is_body(sign):
            sign = sign_under.get((cell.row, cell.col), glyph)
        for name, value in signs.meaning(sign, glyph).items():
            world.cells[kind, name][board.number[cell]] = value


def draw_cells(signs: Signs, board: Board, world: World) -> list[list[str]]:
    """Returns the signs of all cells, without the agents on them."""
    grid = [list(row) for row in board.game.rows]
    fields = {kind.name: signs.fields_of(kind.name) for kind in board.game.kinds}
    for cell, kind in board.kind_of.items():
        number = board.number[cell]
        values = {name: world.cells[kind, name][number] for name in fields[kind]}
        grid[cell.row][cell.col] = signs.draw(kind, values)
    return grid


def draw_picture(signs: Signs, board: Board, world: World) -> list[Row]:
    """Returns the current map with movers and agents over it, and the numbers of all agents."""
    movers = {entity_type: character for character, entity_type in signs.movers.items()}
    cells = draw_cells(signs, board, world)
    snapshot = snapshot_of(board.game, world, ())
    return [Row(*line) for line in with_figures(cells, snapshot, movers, signs.arrows)]


def compare_pictures(expected: Sequence[Row], actual: Sequence[Row]) -> str | None:
    """Returns both pictures one above the other, with the rows that differ marked; None if none do.

    Numbers of agents count only in rows that are expected to have them.
    """
    differs = [
        row.signs != other.signs or (row.numbers is not None and row.numbers != other.numbers)
        for row, other in zip(expected, actual, strict=True)
    ]
    if not any(differs):
        return None
    width = max(len(str(row)) for row in (*expected, *actual))
    lines = []
    for title, rows in (("expected", expected), ("found", actual)):
        lines.append(f"{title}:")
        for index, row in enumerate(rows):
            lines.append(f"  {row!s:{width}}  <- row {index}" if differs[index] else f"  {row}")
    return "\n".join(lines)
