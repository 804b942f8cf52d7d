"""A small orchard, played on the interpreter."""

from collections.abc import Callable
from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.state import default_params
from sjdsl.screen.session import Interpreted, Session, choice_of
from sjdsl.trace.choices import no_actions, random_actions

ORCHARD = Path(__file__).parent / "orchard.sj"
Begin = Callable[..., Session]


@pytest.fixture(scope="session")
def orchard() -> ir.Game:
    return build(read_source(ORCHARD)).game


@pytest.fixture
def begin(orchard: ir.Game) -> Begin:
    """Returns how a session begins: the seed, who is steered, how many steps, whether the others act at random."""

    def session(seed: int = 3, agent: int | None = 0, steps: int = 12, at_random: bool = False) -> Session:
        choose = choice_of(random_actions(orchard, seed) if at_random else no_actions(orchard))
        return Session(Interpreted(orchard, default_params(orchard), seed), choose, agent, steps)

    return session
