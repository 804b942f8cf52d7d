"""Rules with a chance, rewritten: another probability, the chance without this branch, the branch without its chance.

chance p { A } otherwise chance q { B } otherwise { C }
p = 0   ->   chance q { B } otherwise { C }
p = 1   ->   when yes { A }
q = 1   ->   chance p { A } otherwise { B }
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite
from tests.verify_ir import verify

PROBABILITY = ir.Type(kind="real", unit="probability", low=0, high=1)


class Site(NamedTuple):
    """One branch of the chance that draws from this stream."""

    stream: int
    branch: int


def sites(game: ir.Game) -> Iterator[Site]:
    """Yields every branch of every chance of a step."""
    for turn in game.schedule:
        for node in ir.walk(turn):
            if isinstance(node, ir.Chance):
                yield from (Site(node.stream, number) for number in range(len(node.branches)))


def with_constant(game: ir.Game, site: Site, probability: float) -> ir.Game:
    """Returns the game with a number in the place of a probability."""
    return _rewritten(
        game, site, lambda node: _tested(node, site, ir.Number(type=PROBABILITY, value=probability))
    )


def with_param(game: ir.Game, site: Site, probability: float) -> ir.Game:
    """Returns the game with a parameter in the place of a probability, so that no pass knows what it is."""
    param = ir.Param(name="law_says", type=PROBABILITY, value=probability)
    game = game.model_copy(update={"params": (*game.params, param)})
    return _rewritten(
        game, site, lambda node: _tested(node, site, ir.ParamRef(type=PROBABILITY, name=param.name))
    )


def without_branch(game: ir.Game, site: Site) -> ir.Game:
    """Returns the game without a branch, as if its rule had never been written."""

    def rule(node: ir.Chance) -> ir.Stmt:
        rest = tuple(b for number, b in enumerate(node.branches) if number != site.branch)
        return node.model_copy(update={"branches": rest}) if rest else _always(node, node.otherwise)

    return _rewritten(game, site, rule)


def without_chance(game: ir.Game, site: Site) -> ir.Game:
    """Returns the game in which a branch happens wherever none before it does."""

    def rule(node: ir.Chance) -> ir.Stmt:
        body = node.branches[site.branch].body
        before = node.branches[: site.branch]
        return (
            node.model_copy(update={"branches": before, "otherwise": body})
            if before
            else _always(node, body)
        )

    return _rewritten(game, site, rule)


def _always(node: ir.Chance, body: tuple[ir.Stmt, ...]) -> ir.When:
    """Returns a block of its own, so that its names stay inside."""
    return ir.When(branches=(ir.Branch(test=ir.Truth(value=True), body=body),), origin=node.origin)


def _tested(node: ir.Chance, site: Site, test: ir.Expr) -> ir.Chance:
    branches = tuple(
        b.model_copy(update={"test": test}) if n == site.branch else b
        for n, b in enumerate(node.branches)
    )
    return node.model_copy(update={"branches": branches})


def _rewritten(game: ir.Game, site: Site, change: Callable[[ir.Chance], Any]) -> ir.Game:
    def rule(node: Any) -> Any:
        return change(node) if isinstance(node, ir.Chance) and node.stream == site.stream else node

    return verify(
        game.model_copy(update={"schedule": tuple(rewrite(turn, rule) for turn in game.schedule)})
    )
