"""Every bundled game in every variant, as found in the folder of games: what is added there is tested without being listed."""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from sjdsl.compiler import build, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, main_games
from sjdsl.library.substrates import written_substrates

MANY = 20  # agents. Source: the larger number in the paper's table of speeds


class Form(NamedTuple):
    """A game in a variant (None: as it is) with so many agents (None: as many as its file says)."""

    game: str
    variant: str | None = None
    agents: int | None = None

    def __str__(self) -> str:
        named = self.game if self.variant is None else f"{self.game}+{self.variant}"
        return named if self.agents is None else f"{named}, {self.agents} agents"


def variants_of(game: str) -> tuple[str, ...]:
    """Returns the names of the variants of a bundled game, those of the games it extends among them.

    Those that stand for a substrate of Melting Pot, and are not named after it, are tested in `tests/meltingpot/`.
    """
    elsewhere = {s.variant for s in written_substrates() if s.game == game} - {
        "",
        "meltingpot",
        "closed",
        "partnership",
    }
    return tuple(
        name for name in compose(read_source(find_game(game))).variants if name not in elsewhere
    )


@cache
def rules_of(form: Form) -> ir.Game:
    """Returns the typed rules. Raises CompileError where the game does not admit so many agents."""
    variants = (form.variant,) if form.variant else ()
    return build(
        read_source(find_game(form.game)), variants, Overrides(num_agents=form.agents)
    ).game


def all_forms() -> Iterator[Form]:
    """Yields every game, every variant, and every game with `MANY` agents that has room for them."""
    yield from (Form(game) for game in main_games())
    yield from (Form(game, variant) for game in main_games() for variant in variants_of(game))
    for form in (Form(game, agents=MANY) for game in main_games()):
        try:
            rules_of(form)
        except CompileError:
            continue
        yield form


@cache
def forms() -> tuple[Form, ...]:
    """Returns the forms with different rules: of several that have the same (a name and a title aside) the first."""
    found: dict[str, Form] = {}
    for form in all_forms():
        found.setdefault(_hash(rules_of(form)), form)
    return tuple(found.values())


@cache
def programs() -> tuple[Form, ...]:
    """Returns the games, and of the other forms those that differ from all before them in more than run-time numbers and checks."""
    found: dict[str, Form] = {}
    for form in forms():
        rules = rules_of(form)
        params = tuple(param.model_copy(update={"value": 0}) for param in rules.params)
        found.setdefault(_hash(rules.model_copy(update={"params": params, "checks": ()})), form)
    return tuple(form for form in forms() if form == Form(form.game) or form in found.values())


def _hash(rules: ir.Game) -> str:
    return game_hash(rules.model_copy(update={"name": "", "title": "", "variants": ()}))
