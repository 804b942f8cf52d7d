"""The hash of a game: of its printed rules, positions aside."""

import hashlib

from sjdsl.compiler import ir
from sjdsl.compiler.ir.game import BESIDE_THE_RULES
from sjdsl.compiler.ir.printer import game as ir_text

# What nodes and fields are called in the text that is hashed: the names they once had, so that hashes of stored runs stay valid.
HASHED = {"observable": "sight", "observables": "sights", "held_by": "place", "restriction": "place"}


def game_hash(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits that two games share if and only if their IR is equal.

    Positions, `cite`, `about`, `look`, policies and scenarios are left out: they change nothing that happens.
    """
    return printed_digest(game.model_copy(update={"cites": (), "about": (), **dict.fromkeys(BESIDE_THE_RULES, ())}))


def printed_digest(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits of the printed IR, positions aside."""
    return hashlib.sha256(ir_text(game, names=HASHED).encode()).hexdigest()[:16]
