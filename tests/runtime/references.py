"""The kernels once more, in plain Python: written from the manual's semantics, slow and obvious."""

from collections.abc import Iterator, Sequence
from fractions import Fraction

WORD = 2**32
DIRECTIONS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # (row, column) of north, east, south, west


def threefry(key: tuple[int, int], counter: tuple[int, int]) -> tuple[int, int]:
    """Returns threefry-2x32 with 13 rounds. Source: Salmon et al., SC 2011, section 4.2 and table 2."""
    injected = (key[0], key[1], 0x1BD11BDA ^ key[0] ^ key[1])
    left, right = (counter[0] + injected[0]) % WORD, (counter[1] + injected[1]) % WORD
    for round_ in range(13):
        distance = (13, 15, 26, 6, 17, 29, 16, 24)[round_ % 8]
        left = (left + right) % WORD
        right = ((right * 2**distance) % WORD + right // 2 ** (32 - distance)) ^ left
        if round_ % 4 == 3:
            turn = round_ // 4 + 1
            left = (left + injected[turn % 3]) % WORD
            right = (right + injected[(turn + 1) % 3] + turn) % WORD
    return left, right


def float32(value: Fraction) -> Fraction:
    """Returns the float32 nearest to a number of 0 .. 2^32, ties to even, by whole numbers alone (no subnormals)."""
    if value == 0:
        return value
    exponent = 0
    while value / Fraction(2) ** exponent >= 2**24:
        exponent += 1
    while value / Fraction(2) ** exponent < 2**23:
        exponent -= 1
    return (
        round(value / Fraction(2) ** exponent) * Fraction(2) ** exponent
    )  # round() of a Fraction: half to even


def resolve(position: Sequence[int], target: Sequence[int], word: Sequence[int]) -> list[int]:
    """Returns the cells after a move: swaps out, then one winner a cell, then nobody onto one who stays."""
    agents = range(len(position))
    rank = [(w - w % 256) + agent for agent, w in enumerate(word)]
    movers = {a for a in agents if target[a] != position[a]}
    movers -= {
        a for a in movers for b in movers if target[a] == position[b] and target[b] == position[a]
    }
    movers -= {a for a in movers for b in movers if target[a] == target[b] and rank[b] > rank[a]}
    while True:
        taken = {position[a] for a in agents if a not in movers}
        stopped = {a for a in movers if target[a] in taken}
        if not stopped:
            return [target[a] if a in movers else position[a] for a in agents]
        movers -= stopped


def turn_of(word: int, left: list[int]) -> int:
    """Takes one out of a list, all equally likely, and returns it."""
    return left.pop(int(Fraction(word, WORD) * len(left)))


def place(
    cells: Sequence[int],
    free: Sequence[bool],
    words: Sequence[int],
    position: Sequence[int],
    sent: Sequence[bool],
) -> tuple[list[int], list[bool]]:
    """Returns the cells and who was placed: agents in id order take a free cell each, by their own words."""
    left = [s for s in range(len(cells)) if free[s]]
    places, placed = list(position), [False] * len(position)
    for agent in range(len(position)):
        if sent[agent] and left:
            places[agent], placed[agent] = cells[turn_of(words[agent], left)], True
    return places, placed


def choose(member: Sequence[bool], words: Sequence[int], number: int) -> list[bool]:
    """Returns who is picked when `number` are, one after the other."""
    left = [m for m in range(len(member)) if member[m]]
    taken = {turn_of(words[turn], left) for turn in range(min(max(number, 0), len(left)))}
    return [m in taken for m in range(len(member))]


def pair(ranks: Sequence[Sequence[int]], alike: bool) -> list[int]:
    """Returns each left member's partner, the number of right members for none: pairs in rank order, both still free."""
    right = len(ranks[0])
    pairs = sorted(
        (-ranks[a][b], a * right + b)
        for a in range(len(ranks))
        for b in range(right)
        if ranks[a][b] > 0
    )
    partner, lefts, rights = [right] * len(ranks), set[int](), set[int]()
    for _, number in pairs:
        a, b = divmod(number, right)
        if a in lefts or b in rights or (alike and (a in rights or b in lefts)):
            continue
        partner[a] = b
        lefts.add(a)
        rights.add(b)
    return partner


def seen_cell(row: int, col: int, heading: int, ahead: int, right: int) -> tuple[int, int]:
    """Returns the cell so many cells ahead and to the right of one who looks north (0), east, south or west (3)."""
    (ahead_row, ahead_col), (right_row, right_col) = (
        DIRECTIONS[heading],
        DIRECTIONS[(heading + 1) % 4],
    )
    return row + ahead * ahead_row + right * right_row, col + ahead * ahead_col + right * right_col


def cells(rows: Sequence[str]) -> Iterator[tuple[int, int, str]]:
    """Yields the row, column and glyph of each cell of a map, in reading order."""
    for r, row in enumerate(rows):
        for c, glyph in enumerate(row):
            yield r, c, glyph
