"""How a message about an unknown name ends."""

import pytest

from sjdsl.near_names import meant, nearest

GAMES = ("coins", "clean_up", "harvest_open")


@pytest.mark.parametrize(
    ("name", "ending"),
    [
        ("coin", "; did you mean `coins`?"),
        ("claen_up", "; did you mean `clean_up`?"),
        ("harvest", "; the games are coins, clean_up, harvest_open"),
        ("x", "; the games are coins, clean_up, harvest_open"),
    ],
)
def test_the_nearest_or_all(name: str, ending: str) -> None:
    assert meant(name, GAMES, "the games are") == ending


def test_nothing_is_listed_where_nothing_is_known_or_no_list_is_wanted() -> None:
    assert meant("coins", ()) == ""
    assert meant("x", GAMES, "") == ""
    assert meant("x", ("a1", "b1", "a1")) == "; there are a1, b1", "each once"


def test_a_name_is_not_near_itself() -> None:
    assert nearest("coins", ("coins", "coin")) == "coin"
