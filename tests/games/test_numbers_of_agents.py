"""How many agents a game admits: from 2 up to the starts of its map; one more, or one alone, is refused with the reason."""

import re

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError

from .found import Form, rules_of, variants_of

# the most agents, and why not one more. Sources: the starts of the published maps; for Coins the paper; 64 is a limit of the language
MOST = {
    "coins": (2, r"`players` is 3, outside 2 \.\. 2 \(two colours, an agent for each\)"),
    "harvest_open": (
        60,
        r"`players` is 61, outside 2 \.\. 60 \(of 60 gates one stays free for whoever is hit\)",
    ),
    "harvest_closed": (19, "`gate` has 19 cells, and up to 20 agents may be there or come"),
    "harvest_partnership": (19, "`gate` has 19 cells, and up to 20 agents may be there or come"),
    "clean_up": (19, "`gate` has 19 cells for 20 agents"),
    "coop_mining": (18, "`camp` has 18 cells for 19 agents"),
    "gift_refinement": (18, "`camp` has 18 cells for 19 agents"),
    "mushrooms": (64, r"`players` is 65, outside 2 \.\. 64 \(no game has more than 64\)"),
    "pd_arena": (64, r"`players` is 65, outside 2 \.\. 64 \(no game has more than 64\)"),
}
# the same on maps with more starts. Sources: Melting Pot's 60 starts; ours for the others
MOST_OF_A_CROWD = {
    "harvest_closed": (60, r"`players` is 61, outside 2 \.\. 60"),
    "harvest_partnership": (60, r"`players` is 61, outside 2 \.\. 60"),
    "clean_up": (20, "`gate` has 20 cells for 21 agents"),
    "coop_mining": (20, "`camp` has 20 cells for 21 agents"),
    "gift_refinement": (20, "`camp` has 20 cells for 21 agents"),
}


def most_of(form: Form) -> tuple[int, str]:
    crowded = form.variant == "crowd" or form in (
        Form("harvest_closed", "meltingpot"),
        Form("harvest_partnership", "meltingpot"),
    )
    return MOST_OF_A_CROWD.get(form.game, MOST[form.game]) if crowded else MOST[form.game]


def refusal(form: Form) -> str:
    """Returns what is said of a number of agents that is refused."""
    with pytest.raises(CompileError) as refused:
        rules_of(form)
    return "; ".join(f"{d.code} {d.message}" for d in refused.value.diagnostics)


@pytest.mark.parametrize(
    "form", [*map(Form, MOST), *(Form(game, "crowd") for game in MOST_OF_A_CROWD)], ids=str
)
def test_up_to_the_starts_of_the_map(form: Form) -> None:
    check_numbers(form)


@pytest.mark.thorough
@pytest.mark.parametrize("game", MOST)
def test_variants_of_a_map_admit_as_many(game: str) -> None:
    for variant in variants_of(game):
        check_numbers(Form(game, variant))


def check_numbers(form: Form) -> None:
    most, reason = most_of(form)
    assert rules_of(form._replace(agents=most)).agents.number == most
    assert re.search(reason, refusal(form._replace(agents=most + 1)))
    assert "`players` is 1, outside 2 .." in refusal(form._replace(agents=1))
