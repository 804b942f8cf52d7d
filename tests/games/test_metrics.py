"""What each of the nine games counts and measures: for agents where an agent does it, and over time where the tables are means."""

import pytest

from .environments import NINE
from .found import Form, rules_of

# events for each agent (with their words), events of the game, means over time. Source: the cooperation metrics of the paper
AGENTS, GAME, MEANS = 0, 1, 2
HARVEST = ({"eaten": (), "hits": ()}, {}, {"apples_left"})
METRICS = {
    "coins": ({"own_coins": (), "other_coins": ()}, {}, set()),
    "harvest_open": HARVEST,
    "harvest_closed": HARVEST,
    "harvest_partnership": HARVEST,
    "clean_up": ({"eaten": (), "cleaned": (), "hits": ()}, {}, {"clean_water"}),
    "coop_mining": ({"iron_mined": (), "gold_mined": ()}, {"ores_shared": ()}, set()),
    "mushrooms": ({"eaten": ("red", "green", "blue", "orange"), "hits": ()}, {}, set()),
    "gift_refinement": ({"consumed": (), "given": (), "received": ("raw", "cut", "fine")}, {}, {"refined_held"}),
    "pd_arena": ({"collected": ("coop", "defect"), "met": ()}, {}, set()),
}


@pytest.mark.parametrize("game", NINE)
def test_declared_metrics(game: str) -> None:
    rules = rules_of(Form(game))
    assert {e.name: e.by.names if e.by else () for e in rules.events if e.per_agent} == METRICS[game][AGENTS]
    assert {e.name: e.by.names if e.by else () for e in rules.events if not e.per_agent} == METRICS[game][GAME]
    assert {m.name for m in rules.measures} == METRICS[game][MEANS]
    assert all(m.mean for m in rules.measures)
