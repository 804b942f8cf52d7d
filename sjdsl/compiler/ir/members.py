"""How many members a domain can have at once, on the map of its game."""

from sjdsl.compiler.ir.expressions import Among, Domain, InAgents, InCell, Near
from sjdsl.compiler.ir.game import Game
from sjdsl.compiler.ir.queries import glyphs_of, movers_named


def most_members(domain: Domain, game: Game) -> int:
    """Returns the most members that a domain can have, its condition aside."""
    match domain.var.sort.what:
        case "agent":
            everybody = game.agents.number
        case "mover":
            everybody = movers_named(game, domain.var.sort.name).number
        case "cell":
            everybody = num_cells(game, domain.var.kinds)
        case "world":
            raise AssertionError(domain)
    if domain.on is not None:
        everybody = min(everybody, num_cells(game, domain.on.kinds))
    match domain.restriction:
        case Near():
            return min(everybody, sum(map(len, lanes_of(domain.restriction, game))))
        case Among():
            return min(everybody, len(domain.restriction.members))
        case InAgents() if domain.restriction.value.type.kind != "agents":
            return min(everybody, 1)
        case InCell():
            return min(everybody, 1)
        case _:
            return everybody


def num_cells(game: Game, kinds: tuple[str, ...]) -> int:
    """Returns how many cells of these kinds the map has."""
    glyphs = glyphs_of(game, kinds)
    return sum(row.count(glyph) for row in game.rows for glyph in glyphs)


def lanes_of(near: Near, game: Game) -> tuple[tuple[tuple[int, int], ...], ...]:
    """Returns the lanes of the shape in which members are looked for; policies have shapes of their own."""
    return next(shape.lanes for shape in (*game.shapes, *game.policy_shapes) if shape.name == near.shape)
