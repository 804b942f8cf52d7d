"""What the games say of themselves: the paper's two tables exactly, and nothing else under their names."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, main_games

PAPERS = ("paradigm", "long_term_impact", "multi_task", "difficulty")
# SocialJax (ICLR 2026): the classical types of its Schelling diagrams, and its table of characteristics
PUBLISHED = {
    "coins": ("prisoner's dilemma", "low", "no", "easy"),
    "harvest_open": ("commons", "high", "no", "medium"),
    "harvest_closed": ("commons", "high", "no", "hard"),
    "harvest_partnership": ("commons", "high", "no", "hard"),
    "clean_up": ("commons", "high", "yes", "very hard"),
    "coop_mining": ("stag hunt", "medium", "no", "medium"),
    "mushrooms": ("chicken", "high", "no", "easy"),
    "gift_refinement": ("stag hunt", "high", "yes", "very hard"),
    "pd_arena": ("prisoner's dilemma", "medium", "yes", "medium"),
}


def said(game: str, *variants: str) -> dict[str, str]:
    return dict(build(read_source(find_game(game)), variants).game.about)


@pytest.mark.parametrize("game", main_games())
def test_the_papers_tables_and_nothing_else_under_their_names(game: str) -> None:
    """A game that is not in the paper says nothing under the paper's names, also if it is built on one that is."""
    found = said(game)
    assert {key: found[key] for key in PAPERS if key in found} == dict(
        zip(PAPERS, PUBLISHED.get(game, ()), strict=False)
    )


@pytest.mark.parametrize("form", ["closed", "partnership"])
def test_a_map_of_harvest_is_the_same_as_a_variant(form: str) -> None:
    both = [
        {k: v for k, v in one.items() if k != "summary"}
        for one in (said("harvest_open", form), said(f"harvest_{form}"))
    ]
    assert both[0] == both[1]
