"""Hidden Agenda, scene by scene: gems, the beam and its witnesses, votes and who wins. Source: Melting Pot's components."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

ROWS = ("P.G....O...", "P..........", "P.......VVV", "P.......VVV", "P...DDDDD..")
CREW = ["crewmate"] * 4
STAGE = Stage("hidden_agenda", ROWS, 5, params={"regrow": 0, "goal": 3}, interpreted=True)


def put(*picture: str, fields: dict[str, Any] | None = None, **facts: Any) -> Scene:
    """Returns a scene in which nobody's beam needs charging, agent 4 is the impostor and a vote is far away."""
    given = {
        "agent.role": [*CREW, "impostor"],
        "agent.badge": [0, 1, 2, 3, 4],
        "agent.charging": 0,
        "clock": 99,
        **(fields or {}),
    }
    return STAGE.put(*picture, fields=given, **facts)


def test_one_gem_at_a_time_is_carried_to_the_grate() -> None:
    scene = put(
        "P.G<...O...  0", "v.........v  12", "P.......V<V  3", "v.......VVV  4", "P...DDDDD.."
    ).step("forward")
    scene.has(
        {"agent.gem": {0: "gem"}, "vein.gem": "none", "event collected": {0: 1}, "delivered": 0}
    )
    full = put(
        "P.G<...O...  0",
        "v.........v  12",
        "P.......V<V  3",
        "v.......VVV  4",
        "P...DDDDD..",
        fields={"agent.gem": {0: "gem"}},
    ).step("forward")
    full.has({"vein.gem": "gem", "event collected": 0})
    home = put(
        "P.G...>O...  0",
        "v.........v  12",
        "P.......V<V  3",
        "v.......VVV  4",
        "P...DDDDD..",
        fields={"agent.gem": {0: "gem"}},
    ).step("forward")
    home.has({"delivered": 1, "agent.gem": "none", "event deposited": {0: 1}, "reward": 0})


def test_crewmates_win_with_the_last_gem() -> None:
    """Those who are frozen or out too."""
    fields = {"agent.gem": {0: "gem"}, "delivered": 2, "agent.state": {1: "frozen"}}
    scene = put(
        "P.G...>O...  0",
        "v.........v  12",
        "P.......V<V  3",
        "v.......VVV  4",
        "P...DDDDD..",
        fields=fields,
    ).step("forward")
    scene.has({"reward": [1, 1, 1, 1, -1], "event won": 1, "terminated": True})


def test_only_the_impostor_fires_and_freezes_for_ever() -> None:
    """In five lanes, each up to the first; nobody else sees it, so there is no vote."""
    scene = put(
        "P.G....O...", "P....v.....  0", "P..v^...VVV  14", "P.......V>V  3", "v...DDDDD..  2"
    ).step("stay, stay, stay, stay, tag")
    scene.has(
        {
            "agent.state": ["frozen", "frozen", "active", "active", "active"],
            "event tagged": {4: 2},
            "agent.charging": {4: 50},
        }
    )
    scene.has(
        {"allowed forward": {0: False, 1: False, 2: True}, "allowed tag": False, "round": "playing"}
    )
    scene.step().has({"round": "playing", "agent.state": {0: "frozen"}})


def test_walls_do_not_stop_the_beam_but_the_first_agent_of_a_lane_does() -> None:
    """Agent 0 stands behind a wall, agent 1 behind agent 2."""
    stage = Stage(
        "hidden_agenda",
        ("PPPPPVVVVV", ".....DDDDD", ".#..#....."),
        5,
        params={"goal": 3},
        interpreted=True,
    )
    fields = {"agent.role": [*CREW, "impostor"], "agent.charging": 0, "clock": 99}
    scene = stage.put("PPvPPVVVVv  13", "..v..DDDDD  2", "v#^.#.....  04", fields=fields).step(
        "stay, stay, stay, stay, tag"
    )
    scene.has({"agent.state": ["frozen", "active", "frozen", "active", "active"]})


def test_a_witness_calls_a_vote() -> None:
    """Agent 3 looks at the impostor from three cells away; agent 0 sees it too, and is carried to the room, where it is frozen."""
    picture = (
        "P.G....O..v  1",
        "P....v.....  0",
        "P...^..<VVV  43",
        "P.......VVV",
        "v...DDDDD..  2",
    )
    scene = put(*picture).step("stay, stay, stay, stay, tag")
    scene.has({"round": "voting", "agent.state": {0: "frozen", 3: "active"}, "event votes_held": 1})
    assert {scene.under(agent) for agent in range(5)} == {"V"}
    unseen = put(*picture, fields={"agent.state": {3: "frozen"}}).step(
        "stay, stay, stay, stay, tag"
    )
    unseen.has({"round": "playing", "agent.state": {0: "frozen"}})


@pytest.mark.parametrize("between", ["#", "."])
def test_walls_stop_the_rays_that_count_who_can_be_hit(between: str) -> None:
    """The beam freezes agent 0 two cells ahead, which also sees the impostor: one witness, of whom a wall between them hides that it is in reach."""
    rows = ("PPPPPVVVVV", ".....DDDDD", f"..{between}.......", "..........")
    stage = Stage("hidden_agenda", rows, 5, params={"goal": 3}, interpreted=True)
    fields = {"agent.role": [*CREW, "impostor"], "agent.charging": 0, "clock": 99}
    scene = stage.put(
        "PPPPPV^^^V  123", "..v..DDDDD  0", rows[2], "..^.......  4", fields=fields
    ).step("stay, stay, stay, stay, tag")
    scene.has({"round": "voting" if between == "#" else "playing", "agent.state": {0: "frozen"}})


def votes(*ballots: int, state: dict[int, str] | None = None, clock: int = 1) -> Scene:
    """Returns the scene at the end of a vote."""
    fields = {
        "agent.ballot": list(ballots),
        "round": "voting",
        "clock": clock,
        "agent.state": state or {},
    }
    return put(
        "P.G....O...",
        "P..........",
        "P.......v<v  012",
        "P.......v<V  34",
        "P...DDDDD..",
        fields=fields,
    ).step()


def test_who_has_half_of_the_votes_is_out() -> None:
    """Of five three, of four two; the others go back, and the impostor's beam must be charged."""
    scene = votes(1, 5, 1, 1, 0).has(
        {
            "agent.state": ["active", "out", "active", "active", "active"],
            "round": "playing",
            "reward": 0,
        }
    )
    assert scene.under(1) == "D"
    assert {scene.under(agent) for agent in (0, 2, 3, 4)} == {"P"}
    scene.has({"agent.charging": {4: 51}, "clock": 200})
    votes(1, 5, 1, 5, 0).has({"agent.state": "active", "agent.ballot": 5})
    votes(1, 1, 5, 5, 5, state={3: "frozen"}).has({"agent.state": {1: "out"}})
    votes(1, 1, 0, 5, 0, state={3: "frozen"}).has({"agent.state": {0: "out", 1: "active"}})


def test_the_impostor_voted_out_loses_and_the_last_but_one_crewmate_too() -> None:
    votes(4, 4, 4, 5, 0).has({"reward": [1, 1, 1, 1, -1], "terminated": True, "event won": 1})
    votes(1, 1, 5, 5, 1, state={2: "frozen", 3: "frozen"}).has(
        {"reward": [-1, -1, -1, -1, 1], "terminated": True, "event lost": 1}
    )


def test_ballots_can_be_changed_and_taken_back_while_the_vote_lasts() -> None:
    fields = {"round": "voting", "clock": 20, "agent.ballot": 5}
    scene = put(
        "P.G....O...",
        "P..........",
        "P.......v<v  012",
        "P.......v<V  34",
        "P...DDDDD..",
        fields=fields,
    )
    scene.has({"allowed forward": False, "allowed vote(1)": True, "allowed tag": False}).step(
        "vote(4), vote(2), abstain"
    )
    scene.has({"agent.ballot": [4, 2, 5, 5, 5]}).step("vote(1), abstain").has(
        {"agent.ballot": [1, 5, 5, 5, 5]}
    )
    assert scene.seen(3, "everyone[0].ballot") == 1
