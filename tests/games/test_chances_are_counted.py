"""Every rule of the nine games that draws, in every variant that changes it, has a test that counts what it draws."""

import ast
from collections.abc import Iterator
from pathlib import Path

from sjdsl.compiler import ir

from .environments import HARVESTS, NINE
from .found import forms, rules_of

DRAWING = (ir.Chance, ir.Draw, ir.Pick, ir.Match, ir.Send, ir.Move)
STARTS = "test_starts.py test_starts"
ENDINGS = "test_melting_pot_chances.py test_an_episode_ends_by_chance_after_whole_intervals"
CONTESTED = "test_contested_cells.py test_a_contested_cell_goes_to_each_alike"
# game or variant, phase -> the test of its draws; the three rooms of Harvest are one game
TESTS = {
    "clean_up start": STARTS,
    "clean_up grow": "test_clean_up_chances.py test_growth_falls_with_dirt",
    "clean_up pollute": "test_clean_up_chances.py test_dirt_comes_to_every_clean_cell_alike",
    "clean_up walk": CONTESTED,
    "clean_up rinse": "test_clean_up_chances.py test_a_cell_that_several_clean_counts_once_and_for_each_alike",
    "clean_up fire": "test_clean_up_chances.py test_home_is_every_free_gate_alike",
    "clean_up+socialjax grow": "test_clean_up_chances.py test_growth_falls_with_dirt",
    "clean_up+socialjax pollute": "test_clean_up_chances.py test_as_released_dirt_waits_a_step_more_and_is_lost_on_covered_cells",
    "clean_up+socialjax rinse": "test_clean_up_chances.py test_a_cell_that_several_clean_counts_once_and_for_each_alike",
    "clean_up+socialjax fire": "test_clean_up_chances.py test_home_is_every_free_gate_alike",
    "clean_up+meltingpot grow": "test_clean_up_chances.py test_growth_falls_with_dirt",
    "clean_up+meltingpot fire": "test_clean_up_chances.py test_who_was_away_comes_to_every_free_gate_alike",
    "clean_up+meltingpot finish": ENDINGS,
    "coins start": STARTS,
    "coins grow": "test_coins_chances.py test_coins_come_so_often",
    "coins walk": CONTESTED,
    "coins+meltingpot grow": "test_coins_chances.py test_coins_come_so_often",
    "coins+meltingpot finish": ENDINGS,
    "coop_mining start": STARTS,
    "coop_mining walk": CONTESTED,
    "coop_mining settle": "test_coop_mining_chances.py test_contested_iron_goes_to_each_miner_alike",
    "coop_mining grow": "test_coop_mining_chances.py test_iron_and_gold_come_so_often",
    "coop_mining+socialjax grow": "test_coop_mining_chances.py test_iron_and_gold_come_so_often",
    "coop_mining+meltingpot grow": "test_coop_mining_chances.py test_iron_and_gold_come_so_often",
    "coop_mining+meltingpot settle": "test_melting_pot_chances.py test_of_three_miners_two_share",
    "coop_mining+meltingpot finish": ENDINGS,
    "gift_refinement start": STARTS,
    "gift_refinement grow": "test_gift_refinement_chances.py test_a_token_in_five_thousand_cells_and_steps",
    "gift_refinement walk": CONTESTED,
    "gift_refinement+socialjax grow": "test_gift_refinement_chances.py test_a_token_in_five_thousand_cells_and_steps",
    "gift_refinement+meltingpot finish": ENDINGS,
    "harvest_closed start": STARTS,
    "harvest_closed regrow": "test_harvest_chances.py test_growth_for_each_number_of_apples_near",
    "harvest_closed walk": CONTESTED,
    "harvest_closed fire": "test_harvest_chances.py test_home_is_every_free_gate_alike",
    "harvest_closed+meltingpot regrow": "test_harvest_chances.py test_growth_for_each_number_of_apples_near",
    "harvest_closed+meltingpot fire": "test_harvest_chances.py test_who_was_away_comes_to_every_free_gate_alike",
    "harvest_closed+meltingpot finish": ENDINGS,
    "harvest_closed+socialjax start": STARTS,
    "harvest_closed+socialjax regrow": "test_harvest_chances.py test_growth_for_each_number_of_apples_near",
    "harvest_closed+socialjax fire": "test_harvest_chances.py test_home_is_every_free_gate_alike",
    "harvest_open+meltingpot regrow": "test_harvest_chances.py test_growth_for_each_number_of_apples_near",
    "harvest_open+meltingpot fire": "test_harvest_chances.py test_who_was_away_comes_to_every_free_gate_alike",
    "mushrooms start": STARTS,
    "mushrooms walk": CONTESTED,
    **{
        f"mushrooms sprout({kind})": "test_mushrooms_chances.py test_what_grows_after_a_meal"
        for kind in ("red", "green", "blue", "orange")
    },
    "mushrooms fire": "test_mushrooms_chances.py test_home_is_every_free_bare_cell_alike",
    **{
        f"mushrooms+meltingpot sprout({kind})": "test_mushrooms_chances.py test_what_grows_after_a_meal"
        for kind in ("red", "green", "blue", "orange")
    },
    **{
        f"mushrooms+socialjax sprout({kind})": "test_mushrooms_chances.py test_as_released_spores_come_a_step_later"
        for kind in ("red", "green", "blue", "orange")
    },
    "mushrooms+socialjax start": STARTS,
    "mushrooms+socialjax fire": "test_mushrooms_chances.py test_home_is_every_free_bare_cell_alike",
    "mushrooms+meltingpot start": STARTS,
    "mushrooms+meltingpot die": "test_melting_pot_chances.py test_orange_kills_each_red_one_alike",
    "mushrooms+meltingpot judge": "test_melting_pot_chances.py test_who_is_hit_twice_comes_back_on_any_bare_cell",
    "mushrooms+meltingpot finish": ENDINGS,
    "pd_arena start": STARTS,
    "pd_arena grow": "test_pd_arena_chances.py test_growth",
    "pd_arena walk": CONTESTED,
    "pd_arena meet": "test_pd_arena_chances.py test_both_rest_each_for_its_own_time",
    "pd_arena+socialjax grow": "test_pd_arena_chances.py test_growth",
    "pd_arena+socialjax rest": "test_pd_arena_chances.py test_as_released_only_targets_rest",
}


def drawing_phases() -> Iterator[str]:
    """Yields each phase that draws, under the first form that has it so: the same sentences reading the same numbers."""
    seen = set()
    for form in (form for form in forms() if form.game in NINE and form.agents is None):
        rules = rules_of(form)
        values = {p.name: p.value for p in rules.params}
        for phase in (rules.start, *rules.schedule):
            if isinstance(phase, ir.Phase) and any(
                isinstance(node, DRAWING) for node in ir.walk(phase)
            ):
                read = {
                    (node.name, values[node.name])
                    for node in ir.walk(phase)
                    if isinstance(node, ir.ParamRef)
                }
                key = (
                    "harvest" if form.game in HARVESTS else form.game,
                    content(phase),
                    frozenset(read),
                )
                if key not in seen:
                    seen.add(key)
                    yield f"{form} {phase.label}"


def content(value: object) -> object:
    """Returns what a node says, without places in the text and what is proven of its values."""
    if isinstance(value, ir.Node):
        names = [
            name for name in type(value).model_fields if name not in ("origin", "type", "most")
        ]
        return type(value).__name__, *(content(getattr(value, name)) for name in names)
    return tuple(content(item) for item in value) if isinstance(value, tuple) else value


def test_every_drawing_phase_has_a_test() -> None:
    """A new rule that draws, or a variant that changes one: count what it draws, and name the test above."""
    assert sorted(drawing_phases()) == sorted(TESTS)


def test_the_tests_are_there() -> None:
    folder = Path(__file__).parent
    for name in set(TESTS.values()):
        file, function = name.split()
        module = ast.parse((folder / file).read_text(encoding="utf-8"))
        assert function in {
            node.name for node in module.body if isinstance(node, ast.FunctionDef)
        }, name
