"""Dead code elimination: drops unread `let`s and draws; each draw has its own stream, so no other draw changes.

let near = count(…)  set soil.fruit = ripe   ->   set soil.fruit = ripe
"""

from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.traverse import rewrite


def drop_unused(game: ir.Game) -> ir.Game:
    """Returns the game without unread `let`s and `draw`s, and without shapes no rule uses."""
    while True:
        smaller = rewrite(game, _drop)
        if smaller is game:
            return _drop_shapes(game)
        game = smaller


def _drop(node: Any) -> Any:
    if not isinstance(node, ir.Phase | ir.Each | ir.Pick | ir.First | ir.Match | ir.When | ir.Chance | ir.Branch):
        return node
    update = {}
    for name in ("body", "otherwise"):
        block = getattr(node, name, ())
        kept = tuple(s for i, s in enumerate(block) if not _unread(s, block[i + 1 :]))
        if len(kept) != len(block):
            update[name] = kept
    return node.model_copy(update=update) if update else node


def _unread(s: ir.Stmt, rest: tuple[ir.Stmt, ...]) -> bool:
    if not isinstance(s, ir.Let | ir.Draw):
        return False
    return not any(isinstance(n, ir.Local) and n.name == s.name for after in rest for n in ir.walk(after))


def _drop_shapes(game: ir.Game) -> ir.Game:
    used = {n.shape for n in ir.walk(game) if isinstance(n, ir.Near | ir.Mark | ir.Aim)}
    kept = tuple(s for s in game.shapes if s.name in used)
    if len(kept) == len(game.shapes):
        return game
    aimed = {n.shape for policy in game.policies for n in ir.walk(policy) if isinstance(n, ir.Aim)}
    left_to_policies = tuple(s for s in game.shapes if s.name in aimed - used)
    return game.model_copy(update={"shapes": kept, "policy_shapes": (*game.policy_shapes, *left_to_policies)})
