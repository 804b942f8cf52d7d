"""Policies, scenarios and what only they speak of are no part of a game's hash; defines and shapes that only they use are used."""

import re
from pathlib import Path

from sjdsl.compiler import Build, build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.hash import game_hash

CASE = (Path(__file__).parents[1] / "cases" / "policies.sj").read_text("utf-8")
CHECKED = CASE[CASE.index("  checks {") :]
BESIDE_THE_RULES = r"  (policy|scenario|shape beside|define sated).*?\n(?=  \w|})"


def built(text: str) -> Build:
    return build(Source("policies.sj", text.replace(CHECKED, "}\n")))


def test_a_game_without_its_policies_has_the_same_hash() -> None:
    whole, bare = built(CASE), built(re.sub(BESIDE_THE_RULES, "", CASE, flags=re.DOTALL))
    assert (len(whole.game.policies), len(bare.game.policies)) == (2, 0)
    assert game_hash(whole.game) == game_hash(bare.game)
    assert list(whole.warnings) == []


def test_an_action_that_only_a_policy_chooses_does_nothing_and_is_warned_of() -> None:
    text = CASE.replace("stay, zap", "stay, zap, sing").replace(
        "5 choose turn_left", "5 choose sing"
    )
    assert [(warning.code, warning.message) for warning in built(text).warnings] == [
        ("SJ506", "no rule reads the action `sing`, so choosing it is the same as `stay`")
    ]
