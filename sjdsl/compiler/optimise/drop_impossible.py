"""Dead code elimination: drops statements that can never run.

chance 0 { … } otherwise { A }   ->   A          each wall { … } on a map without walls   ->   (nothing)
"""

from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.traverse import rewrite


def drop_impossible(game: ir.Game) -> ir.Game:
    """Returns the game without branches of constant conditions, chances of 0, and statements about kinds that are not on the map."""
    glyphs = {g.glyph: g.kind for g in game.glyphs}
    present = {glyphs[g] for row in game.rows for g in row}

    def rule(node: Any) -> Any:
        match node:
            case ir.When():
                return _when(node)
            case ir.Chance():
                return _chance(node)
            case ir.Each() if _empty(node.domain, present) or not node.body:
                return ()
            case ir.Pick() if _empty(node.domain, present):
                return node.otherwise
            case _:
                return node

    return rewrite(game, rule)


def _empty(domain: ir.Domain, present: set[str]) -> bool:
    kinds = domain.on.kinds if domain.on is not None else domain.var.kinds if domain.var.who == "cell" else None
    return kinds is not None and not present & set(kinds)


def _when(node: ir.When) -> Any:
    branches: list[ir.Branch] = []
    for branch in node.branches:
        if isinstance(branch.test, ir.Truth):
            if not branch.test.value:
                continue
            if not branches:
                return branch.body
            return node.model_copy(update={"branches": tuple(branches), "otherwise": branch.body})
        branches.append(branch)
    if not branches:
        return node.otherwise
    if not node.otherwise and not any(b.body for b in branches):
        return ()
    return node if len(branches) == len(node.branches) else node.model_copy(update={"branches": tuple(branches)})


def _chance(node: ir.Chance) -> Any:
    """A chance of 0 takes nothing from those after it, so it can go; one of 1 leaves nothing to them."""
    branches = tuple(b for b in node.branches if not (isinstance(b.test, ir.Number) and b.test.value == 0))
    if not branches:
        return node.otherwise
    if isinstance(branches[0].test, ir.Number) and branches[0].test.value == 1:
        return branches[0].body
    return node if len(branches) == len(node.branches) else node.model_copy(update={"branches": branches})
