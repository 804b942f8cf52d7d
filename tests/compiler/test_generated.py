"""`generated/` is what the compiler writes: the golden of whole games."""

from pathlib import Path

import pytest

from sjdsl.compiler import compile_source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, main_games

GENERATED = Path(__file__).parent.parent.parent / "generated"


@pytest.mark.parametrize("name", main_games())
def test_generated_module_is_current(name: str) -> None:
    written = (GENERATED / f"{name}.py").read_text(encoding="utf-8")
    assert written == compile_source(read_source(find_game(name))), (
        "run `sjdsl compile games/*.sj` and read the difference"
    )
