"""Ferry to a Market that Remembers, scene by scene: harvest, crossing, and prices by the sales of the last days."""

import pytest

from .environments import stage_of

ROWS = ("ff.DdlllD.ss", "...DrrruD...")
STAGE = stage_of("ferry", ROWS, 2, arrows="AWVE")
EMPTY = "...DrrruD..."


def test_only_the_owner_harvests_a_plot() -> None:
    scene = STAGE.put("AA.DblllD.ss", EMPTY, fields={"agent.home": {0: (0, 0), 1: (0, 0)}}).step()
    scene.has({"agent.load": [1, 0], "event grown": [1, 0], "farm.crop": ["none", "ripe"]})
    scene.step().has({"agent.load": [1, 0]})  # it rests
    scene.step(times=2).has({"agent.load": [2, 0]})


def test_the_boat_goes_round_along_the_lanes() -> None:
    scene = STAGE.put("AA.DdbllD.ss", EMPTY)
    columns = []
    for _ in range(6):
        columns.append(scene.step().value("boat.col")[0])
    assert columns == [4, 4, 5, 6, 7, 7]


@pytest.mark.parametrize(("boat", "crosses"), [("ff.AdbllD.As", True), ("ff.AdlblD.As", False)])
def test_who_boards_at_a_dock_where_the_boat_lies_lands_across(boat: str, crosses: bool) -> None:
    scene = STAGE.put(boat, EMPTY).step("board, stay")
    scene.has({"event crossed": [int(crosses), 0], "agent.away": [crosses, False]})
    scene.step(times=4)
    assert scene.places()[0] == ((0, 8) if crosses else (0, 3))


@pytest.mark.parametrize(
    ("sold", "price"), [([0, 0, 0, 0, 0], 10), ([1, 2, 0, 0, 1], 6), ([9, 9, 0, 0, 0], 1)]
)
def test_the_price_falls_with_the_sales_that_are_remembered(sold: list[int], price: int) -> None:
    scene = STAGE.put(
        "ff.DblllD.As",
        "A..DrrruD...",
        fields={"agent.load": [2, 0], "sold": dict(enumerate(sold))},
        step=1,
    )
    scene.step("sell, sell").has(
        {"reward": [price, 0], "agent.load": [1, 0], "event sold_": [1, 0]}
    )
    scene.has({"sold": dict(enumerate([sold[0] + 1, *sold[1:]]))})


def test_the_market_forgets_day_by_day() -> None:
    scene = STAGE.put(
        "Af.DblllD.As", EMPTY, fields={"sold": dict(enumerate([1, 2, 3, 4, 5]))}, step=9
    )
    for _ in range(2):  # the second step is no end of a day
        scene.step().has({"sold": dict(enumerate([0, 1, 2, 3, 4]))})
