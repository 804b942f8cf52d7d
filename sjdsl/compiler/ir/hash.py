"""The hash of a game: of its printed rules, positions aside."""

import hashlib

from sjdsl.compiler import ir
from sjdsl.compiler.ir.printer import game as ir_text


def game_hash(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits that two games share if and only if their IR is equal (positions, `cite`, `about` and `look` aside)."""
    rules = game.model_copy(update={"cites": (), "about": (), "looks": ()})
    return hashlib.sha256(ir_text(rules).encode()).hexdigest()[:16]
