"""The functions that phases become: one for all uses of a phase, with the phase's own text, its lines said once."""

import re
from itertools import pairwise
from pathlib import Path

import pytest

from sjdsl.compiler import build, compile_rules, compile_source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, main_games

CASES = Path(__file__).parents[1] / "cases"
GENERATED = Path(__file__).parents[2] / "generated"


def functions(text: str) -> dict[str, str]:
    """Returns the functions of a module by name."""
    parts = re.split(r"\n(?=def (\w+)\()", text)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def test_uses_of_a_phase_are_calls_of_one_function() -> None:
    found = functions(compile_source(read_source(CASES / "rows.sj")))
    assert {name for name in found if name.startswith("trade")} == {"trade"}
    assert re.findall(r"trade\(.*\)", found["step"]) == [
        "trade(state, out, params, actions, key, AGENT_BAG_RAW)",
        "trade(state, out, params, actions, key, AGENT_BAG_CUT)",
    ]
    assert "agent_bag_what: int" in found["trade"] and "AGENT_BAG_RAW" not in found["trade"]


def test_a_word_in_two_sets_is_one_parameter() -> None:
    """The colours of Mushrooms: what the ground grows may also be `none`, which comes first there."""
    found = functions((GENERATED / "mushrooms.py").read_text("utf-8"))
    assert re.findall(r"(\w+): int", found["sprout"]) == ["ground_what", "stream", "stream_2"]
    assert "params.crowd[ground_what - 1]" in found["sprout"]


def test_words_of_two_parameters_stay_apart() -> None:
    """The actions and colours that `sow` is used with differ by the same number everywhere."""
    found = functions((GENERATED / "allelopathic_harvest.py").read_text("utf-8"))
    assert re.findall(r"(\w+): int", found["sow"]) == ["action_deed", "agent_hue"]


def test_uses_that_differ_by_more_than_numbers_have_functions_of_their_own() -> None:
    found = functions(compile_source(read_source(CASES / "shifting.sj")))
    assert len([name for name in found if name.startswith("roll")]) == 2


@pytest.mark.parametrize("name", main_games())
def test_a_function_has_the_text_of_its_phase(name: str) -> None:
    sources = " ".join(
        source.text for source in build(read_source(find_game(name))).sources.values()
    ).replace('"', "'")
    for function, text in functions((GENERATED / f"{name}.py").read_text("utf-8")).items():
        if written := re.search(r'"""(phase .*?)\s*"""', text, re.DOTALL):
            assert written[1].split("(")[0].split()[1] == function.removesuffix("_phase")
            assert " ".join(written[1].split()) in " ".join(sources.split())


def test_what_is_cached_for_all_has_no_text_of_a_file() -> None:
    text = compile_rules(build(read_source(CASES / "rows.sj")))
    assert "phase trade" not in text and "what" not in functions(text)["trade"]


@pytest.mark.parametrize("name", main_games())
def test_a_line_of_the_game_is_said_once_for_all_that_follows(name: str) -> None:
    for text in functions((GENERATED / f"{name}.py").read_text("utf-8")).values():
        said = re.findall(r"# (\S+\.sj:\d+)$", text, re.MULTILINE)
        assert all(one != following for one, following in pairwise(said))
