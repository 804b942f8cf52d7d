"""Allelopathic Harvest as Melting Pot has it, scene by scene: meals, coats, seeds that stop at players, sanctions."""

from typing import Any

from sjdsl.testing import Scene, Stage

ROWS = ("123.....", "........", "..1123..", "........")
LOOKS = {
    "R": "bush colour=red fruit=ripe",
    "G": "bush colour=green fruit=ripe",
    "B": "bush colour=blue fruit=ripe",
}
STAGE = Stage("allelopathic_harvest_open", ROWS, 4, looks=LOOKS, interpreted=True)


def put(*picture: str, **facts: Any) -> Scene:
    """Returns a scene of old bushes in which nothing ripens; agents 0 and 1 like red, 2 and 3 green, as at the start."""
    fields = {"bush.young": 0, **facts.pop("fields", {})}
    return STAGE.put(
        *picture, params={"growth": 0, **facts.pop("params", {})}, fields=fields, **facts
    )


def test_half_like_red_and_half_like_green() -> None:
    STAGE.start().has(
        {"agent.taste": ["red", "red", "green", "green"], "bush.fruit": "unripe", "bush.young": 10}
    )


def test_a_berry_is_eaten_by_who_enters_and_is_worth_two_to_who_likes_it() -> None:
    facts = {"agent.taste": ["red", "green", "red", "red"]}
    scene = put("RGB..<..  2", "^^......  01", "..1123..", ".......<", fields=facts).step(
        "forward, forward"
    )
    scene.has({"reward": [2, 2, 0, 0], "event eaten[red]": [1, 0, 0, 0]})
    scene.step("stay, step_right").has({"reward": [0, 1, 0, 0]})
    below = put("RGB..<..  2", "........", "..1123..", "^..^...^  013", under={}, fields=facts)
    below.step().has({"reward": 0})


def test_a_berry_that_ripens_under_a_player_is_eaten_by_it_once() -> None:
    """Who has eaten on a bush waits there in vain for the next berry; it eats again when it comes anew."""
    picture = ("123..<..  1", "^.......  0", "..1123..", "......<<  23")
    facts = {"agent.taste": "red", "bush.fruit": "ripe"}
    below = (
        put("^23..<..  01", "........", "..1123..", "......<<  23", fields=facts)
        .step()
        .has({"reward": [2, 0, 0, 0]})
    )
    below.has({"agent.fed": {0: "yes"}, "bush.fruit": {(0, 0): "unripe"}})
    fed = {**facts, "agent.fed": {0: "yes"}}
    put("^23..<..  01", "........", "..1123..", "......<<  23", fields=fed).step().has(
        {"reward": 0, "bush.fruit": "ripe"}
    )
    put(*picture, fields=fed).step("forward").has({"reward": [2, 0, 0, 0]}).step().has(
        {"reward": 0}
    )


def test_eating_may_cost_the_coat() -> None:
    """With the share of the colours that are not the commonest: four of seven here; in 40 runs, five standard deviations are 0.39."""
    picture = ("R23..<..  1", "^.......  0", "..1123..", "......<<  23")
    scenes = [
        put(*picture, fields={"agent.coat": "blue"}, seed=seed).step("forward")
        for seed in range(40)
    ]
    coats = [scene.value("agent.coat")[0] for scene in scenes]
    assert set(coats) == {"blue", "none"}
    assert abs(coats.count("none") / 40 - 4 / 7) < 0.39
    assert (
        put(*picture, fields={"agent.coat": "blue"}, params={"certain": 0})
        .step("forward")
        .value("agent.coat")[0]
        == "blue"
    )


def test_seeds_fall_on_the_first_bush_and_stop_at_players() -> None:
    scene = put("123.<...  0", "........", "..1123..", ".>>....<  123").step("sow_red")
    scene.shows("121.<...  0", "........", "..1123..", ".>>....<  123").has(
        {"agent.coat": {0: "red"}, "allowed sow_blue": {0: False}}
    )
    blocked = put("123<<...  10", "........", "..1123..", ".>.....<  23").step("sow_red")
    blocked.shows("123<<...  10", "........", "..1123..", ".>.....<  23").has(
        {"agent.coat": "none", "event planted[red]": 0}
    )
    ripe = put("12B.<...  0", "........", "..1123..", ".>>....<  123").step("sow_red")
    ripe.has({"agent.coat": "none", "event planted[red]": 0})


def test_who_is_stunned_sows_and_does_nothing_else() -> None:
    scene = put(
        "123<....  0", "...^....  1", "..1123..", ".>.....<  23", params={"frozen": 2, "cooling": 1}
    ).step("stay, zap")
    scene.has(
        {
            "agent.hits": [1, 0, 0, 0],
            "allowed forward": {0: False},
            "allowed zap": {0: False},
            "allowed sow_red": {0: True},
        }
    )
    scene.step("sow_red").has({"event planted[red]": [1, 0, 0, 0]})


def test_a_second_hit_sends_away_at_a_cost() -> None:
    facts = {"params": {"cooling": 0}, "fields": {"agent.coat": "red"}}
    scene = (
        put("123<....  0", "...^....  1", "..1123..", ".>.....<  23", **facts)
        .step("stay, zap")
        .has({"reward": 0})
    )
    scene.step("stay, zap").has(
        {
            "reward": [-10, 0, 0, 0],
            "agent.away": [True, False, False, False],
            "agent.coat": {0: "none"},
        }
    )
    scene.step(times=26).has({"agent.away": {0: True}}).step().has(
        {"agent.away": False, "allowed forward": True, "agent.hits": 0}
    )


def test_growth_is_by_the_number_of_bushes_of_a_colour() -> None:
    """With 0.001 for each of 100 bushes of one colour, each ripens with 0.1; in 300 bushes, five standard deviations are 0.09."""
    stage = Stage(
        "allelopathic_harvest_open",
        (*["1" * 100], *["2" * 100] * 2, "." * 100),
        2,
        interpreted=True,
    )
    fields = {"bush.young": 0}
    scene = stage.put(
        "1" * 100, *["2" * 100] * 2, "<" + "." * 98 + ">", fields=fields, params={"growth": 0.001}
    ).step()
    fruit = scene.value("bush.fruit")
    assert abs(fruit[:100].count("ripe") / 100 - 0.1) < 0.15
    assert abs(fruit[100:].count("ripe") / 200 - 0.2) < 0.15
