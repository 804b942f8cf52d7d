"""The bundled games' rules as the folders of these tests have them."""

from collections.abc import Iterator
from unittest import mock

import pytest
from report_folders import AGENTS, RULES, VARIANTS


@pytest.fixture(autouse=True)
def fixed_rules() -> Iterator[None]:
    """Has what results say not depend on today's rules; those of harvest_open have changed since."""
    known = {
        (game, ""): (rules, AGENTS[game])
        for game, rules in {**RULES, "harvest_open": "new"}.items()
    }
    known |= {
        ("coins", "socialjax"): ("c02", 2),
        ("gift_refinement", "socialjax+automatic"): ("a17", 5),
    }
    with (
        mock.patch("sjdsl.results.selecting.rules_now", lambda *game: known.get(game)),
        mock.patch("sjdsl.results.loading.variant_now", lambda _, rules: VARIANTS.get(rules)),
    ):
        yield
