"""Our games against the figures of Melting Pot itself in original.toml, which were measured there."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import numpy as np
import pytest

from sjdsl import make
from sjdsl.interop.melting_pot_observations import observe
from sjdsl.library.substrates import Substrate, substrates
from sjdsl.testing import Scene, Stage

pytestmark = pytest.mark.thorough  # each game has scenes of its own; these are about its numbers

ORIGINAL: dict[str, Any] = tomllib.loads(
    (Path(__file__).parent / "original.toml").read_text(encoding="utf-8")
)
LEFT_OUT = {
    "NUM_OTHERS_WHO_CLEANED_THIS_STEP",
    "MISMATCHED_COIN_COLLECTED_BY_PARTNER",
    "HUNGER",
    "MY_OFFER",
    "OFFERS",
}  # docs/meltingpot.md


def stage(
    name: str, rows: tuple[str, ...] | None = None, agents: int | None = None, **params: Any
) -> Stage:
    """Returns a substrate on a map of one's own."""
    entry = substrates()[name]
    return Stage(
        entry.game, rows, agents, variant=entry.variant or None, params=params, interpreted=True
    )


def steps_until(
    scene: Scene, happened: Callable[[Scene], bool], actions: str = "", most: int = 400
) -> int:
    """Returns after how many steps of these actions something has happened."""
    for step in range(1, most + 1):
        if happened(scene.step(actions)):
            return step
    raise AssertionError(f"not in {most} steps")


@pytest.mark.parametrize("name", ORIGINAL["endings"]["first_ending"])
def test_an_episode_first_ends_by_chance_when_the_original_does(name: str) -> None:
    first, period = ORIGINAL["endings"]["first_ending"][name], ORIGINAL["endings"]["period"]
    scene = stage(name, ending=1).start(seed=0)
    for step in (first - 100, first - 1, first, first + 1, first + period):
        scene.world.step = step - 1
        assert scene.step().terminated == (step in (first, first + period)), step


PAIRS: dict[str, tuple[tuple[str, ...], tuple[str, ...], dict[str, Any]]] = {
    "territory__open": (("P.P....",), (">.<....",), {}),
    "allelopathic_harvest__open": (
        ("1...........",) * 3,
        ("1...........", "1>.<........", "1..........."),
        {"growth": 0},
    ),
    "externality_mushrooms__dense": (("..........",), (">.<.......",), {}),
}


def zapped(name: str) -> Scene:
    rows, picture, params = PAIRS[name]
    return stage(name, rows, 2).put(*picture, params=params).step("zap")


@pytest.mark.parametrize("name", PAIRS)
def test_who_is_zapped_moves_zaps_and_is_back_when_it_is_there(name: str) -> None:
    figures = ORIGINAL["zaps"][name]
    assert (
        steps_until(zapped(name), lambda s: s.headings()[1] != "west", "stay, turn_left")
        == figures["moves"]
    )
    scene, zap = zapped(name), stage(name, PAIRS[name][0], 2).env.action_names.index("zap")
    assert steps_until(scene, lambda s: bool(s.allowed[1, zap])) + 1 == figures["zaps"]
    for after, counts in (
        (figures["second_zap_counts_until"], True),
        (figures["second_zap_counts_until"] + 1, False),
    ):
        again = zapped(name).step(times=after - 1).step("zap")
        assert again.value("agent.away")[1] == counts
    if "back" in figures:
        gone = zapped(name).step(times=9).step("zap")
        assert steps_until(gone, lambda s: not s.value("agent.away")[1]) == figures["back"]


def test_one_colour_is_sown_as_often() -> None:
    scene = stage("allelopathic_harvest__open", PAIRS["allelopathic_harvest__open"][0], 2).put(
        "1...........", "1>.<........", "1..........."
    )
    sow = scene.env.action_names.index("sow_green")
    scene.step("sow_green")
    again = (
        1 if scene.allowed[0, sow] else 1 + steps_until(scene, lambda s: bool(s.allowed[0, sow]))
    )
    assert again == ORIGINAL["waits"]["sowing"]


def test_a_claim_pays_after_the_same_time() -> None:
    scene = (
        stage("territory__open", ("P.R.", "....", "P..."), 2)
        .put("v.R.", "....", "v...", params={"rate": 1})
        .step("turn_left")
        .step("forward")
    )
    assert scene.value("brick.owner") == [0]
    assert steps_until(scene, lambda s: s.reward[0] > 0) == ORIGINAL["waits"]["drying"]


def test_who_is_shot_down_is_back_after_the_same_time() -> None:
    rows = ("P.......", "R......B", "Q.......")
    scene = (
        stage("paintball__capture_the_flag", rows, 2)
        .put(">.<.....  01", *rows[1:], fields={"agent.health": {1: 1}})
        .step("spray")
    )
    assert (
        steps_until(scene, lambda s: not s.value("agent.away")[1])
        == ORIGINAL["waits"]["paintball_back"]
    )


@pytest.mark.parametrize("name", ORIGINAL["meetings"])
def test_what_follows_a_meeting(name: str) -> None:
    """The bags are those that met there."""
    figures = ORIGINAL["meetings"][name]
    place = stage(name, ("PPPP....", "........", ".......1"), 2)
    words = next(
        field.type.indexed_by[0].names
        for field in place.env.game.agents.fields
        if field.name == "bag"
    )
    bags = {
        "agent.bag": {
            agent: dict(zip(words, bag, strict=True)) for agent, bag in enumerate(figures["shown"])
        }
    }
    scene = place.put("PPPP....", "..><....  01", ".......1", fields=bags).step("interact")
    assert told(name, scene, "INTERACTION_INVENTORIES")[0].tolist() == figures["shown"]
    assert told(name, scene.step(), "INTERACTION_INVENTORIES")[0].tolist() == figures["shown_later"]
    assert 1 + steps_until(scene, lambda s: s.reward[0] != 0) == figures["reward"]
    if "end" in figures:
        assert figures["reward"] + steps_until(scene, lambda s: s.terminated) == figures["end"]
    else:
        assert (
            figures["reward"] + steps_until(scene, lambda s: not s.value("agent.away")[0])
            == figures["back"]
        )


def told(name: str, scene: Scene, observation: str) -> Any:
    """Returns one of Melting Pot's observations in a scene, without a compiled game."""
    fields = {f"agent_{field}": values for field, values in scene.world.agents.items()}
    here = [int(place is not None) for place in scene.world.position]
    return observe(
        scene.env,
        SimpleNamespace(position=here, **fields),
        substrates()[name].observations[observation],
    )


@pytest.mark.parametrize(
    "name", [name for name, figures in ORIGINAL["meetings"].items() if "regrowth" in figures]
)
def test_resources_come_back_after_the_same_time(name: str) -> None:
    scene = stage(name, ("PP......", "........", ".......1"), 2).put(
        "PP......", "^.......", "......>1  0", params={"regrow": 1}, under={}
    )
    scene.step("forward").step("backward")
    assert (
        1 + steps_until(scene, lambda s: s.value("patch.stock") == ["ripe"])
        == ORIGINAL["meetings"][name]["regrowth"]
    )


def test_votes_of_hidden_agenda() -> None:
    figures = ORIGINAL["hidden_agenda"]
    rows = ("P.........VVV", "P........VVVV", "P............", "PP..DDDDD....")
    quiet = stage("hidden_agenda", rows, 5, regrow=0)
    tag, vote = (quiet.env.action_names.index(name) for name in ("tag", "vote(0)"))
    assert (
        1 + steps_until(quiet.start(0), lambda s: bool(s.allowed[4, tag])) == figures["first_shot"]
    )
    scene = quiet.start(0)
    assert steps_until(scene, lambda s: s.value("round") == "voting") == figures["vote_begins"]
    assert ballots(scene) == figures["ballots"]
    assert steps_until(scene, lambda s: s.value("round") == "voting") == figures["next_vote"]
    fields = {"agent.role": ["crewmate"] * 4 + ["impostor"], "agent.charging": 0, "clock": 99}
    picture = ("P.........VV<  3", "P......^.VVVV  2", "P..>.<.......  40", "PP^.DDDDD....  1")
    shot = quiet.put(*picture, fields=fields).step("stay, stay, stay, stay, tag")
    assert shot.value("agent.state").count("frozen") == 1 and bool(shot.allowed[2, vote])
    assert sum(shot.under(agent) == "V" for agent in range(5)) == figures["carried"]
    assert ballots(shot, voter=2) == figures["ballots_after_a_shot"]


def ballots(scene: Scene, voter: int = 0) -> int:
    """Returns in how many steps a vote can be cast or changed."""
    counted = 0
    while scene.step(", ".join(["stay"] * voter + [f"vote({counted % 2})"])).events["voted"][voter]:
        counted += 1
    return counted


def test_lights_and_periods_of_boat_race() -> None:
    """Everybody stays ashore, so that the boats do not matter; who has landed by then stays in the game."""
    figures = ORIGINAL["boat_race"]
    rows = (
        "NNNN",
        ".hh.",
        "lnnl",
        "l..l",
        "~bb~",
        "~aa~",
        "~ww~",
        "~BB~",
        "l..l",
        "lssl",
        "lHHl",
        "SSSS",
        "PPPP",
    )
    scene, changes = stage("boat_race__eight_races", rows, 2).start(0), []
    scene.world.agents["state"] = ["landed", "landed"]
    lights = scene.value("lights")
    for now in range(1, figures["green"] + figures["period"] + 1):
        if scene.step().value("lights") != lights:
            lights = scene.value("lights")
            changes.append((lights, now))
    first = [figures[colour] for colour in ("yellow", "green", "red")]
    again = [figures[colour] + figures["period"] for colour in ("yellow", "green")]
    assert changes == list(
        zip(("yellow", "green", "red", "yellow", "green"), first + again, strict=True)
    )


@pytest.mark.parametrize(
    "case",
    ORIGINAL["factory_commons"]["released"],
    ids=lambda case: f"{case['machines']}-{case['fed']}",
)
def test_what_machines_give_as_released(case: dict[str, Any]) -> None:
    """A cube is held under each mouth by who turns to it in time."""
    sorts, fed = case["machines"], case["fed"]
    parts = {"s": ("S=..", ".m..", ".n..", "...."), "t": ("G=..", ".m..", ".n..", "....")}
    rows = tuple(
        "#" + "".join(part) + "#" for part in zip(*[parts[sort] for sort in sorts], strict=True)
    )
    board = ("#" * len(rows[0]), *rows, "#" * len(rows[0]))
    place = Stage("factory_commons", board, len(sorts), variant="released", interpreted=True)
    picture = [*board[:2], "#" + ">m.." * len(sorts) + "#", *board[3:]]
    scene = place.put(*picture, fields={"agent.hand": "cube"})
    given: dict[tuple[int, int], int] = {}
    for step in range(1, max(fed) + 20):
        actions = [
            "turn_left" if step == at - 1 else "stay" for at in fed
        ]  # who faces a mouth in a step feeds it
        scene.step(", ".join(actions))
        for machine in range(len(sorts)):
            for outlet, row in enumerate((2, 3)):
                if lies(scene, row, 4 * machine + 2):
                    given.setdefault((machine, outlet), step)
    assert [[given.get((m, o), 0) for o in (0, 1)] for m in range(len(sorts))] == case["gives"]


def lies(scene: Scene, row: int, col: int) -> bool:
    """Returns whether a cube or an apple lies on a cell of the floor."""
    cells = [
        (r, c)
        for r, line in enumerate(scene.env.game.rows)
        for c, glyph in enumerate(line)
        if glyph in ".mn="
    ]
    number = cells.index((row, col))
    return "here" in (scene.value("floor.cube")[number], scene.value("floor.apple")[number])


def test_predators_and_prey() -> None:
    figures = ORIGINAL["predator_prey"]
    two = stage(
        "predator_prey__open",
        ("XXPP....", "........"),
        3,
        hunters=2,
        growth={"apple": 0, "acorn": 0},
    )
    roles = {"agent.role": ["predator", "predator", "prey"]}
    scene = two.put("XXPP....", "..><<...  021", fields=roles).step("bite, bite")
    assert scene.reward[:2] == figures["paid"]
    assert steps_until(scene, lambda s: not s.value("agent.away")[2]) == figures["back"]
    one = stage(
        "predator_prey__open",
        ("XXPP....", "........"),
        2,
        hunters=1,
        growth={"apple": 0, "acorn": 0},
    )
    bite = one.put("XXPP....", "..><....  01", fields={"agent.role": ["predator", "prey"]}).step(
        "bite"
    )
    stamina = [bite.value("agent.stamina")[0]] + [
        bite.step("backward").value("agent.stamina")[0] for _ in range(6)
    ]
    assert stamina == figures["stamina_from_the_bite"]
    fields = {"agent.role": ["predator", "prey"], "agent.hand": {1: "acorn"}}
    prey = one.put("<XPP....  0", ">.......  1", fields=fields).step("stay, bite")
    moved, paid = [], []
    for after in range(1, 28):
        prey.step("stay, forward" if after <= 7 else "")
        moved += [after] * prey.value("agent.moved")[1]
        paid += [after] * (prey.reward[1] > 0)
    assert (moved, paid) == (figures["walks_while_eating"], figures["acorn_pays"])


@pytest.mark.parametrize("name", ORIGINAL["ready_to_shoot"])
def test_ready_to_shoot_rises_as_there(name: str) -> None:
    scene = stage(name).start(0)
    action = next(
        own for own in ("zap", "spray", "mine", "gift", "interact") if own in scene.env.action_names
    )
    found = [told(name, scene.step(action), "READY_TO_SHOOT")[0]]
    while found[-1] < 1:
        found.append(told(name, scene.step(), "READY_TO_SHOOT")[0])
    assert found == pytest.approx(ORIGINAL["ready_to_shoot"][name], abs=1e-3)


@pytest.mark.parametrize("entry", substrates().values(), ids=lambda entry: entry.name)
def test_observations_have_the_names_of_the_original(entry: Substrate) -> None:
    listed = [name for name in ORIGINAL["observations"][entry.name] if name not in LEFT_OUT]
    assert sorted(entry.observations) == sorted(listed)


def test_starts_of_territory_are_those_of_the_original() -> None:
    rows = stage("territory__open").env.game.rows
    assert [
        [r, c] for r, row in enumerate(rows) for c, glyph in enumerate(row) if glyph == "P"
    ] == ORIGINAL["starts"]["territory__open"]


def random_play(game: str, variant: str | None, episodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns for each episode the rewards of all players together in a thousand steps, and in which step it ended, a thousand if in none."""
    env = make(game, variant=variant)

    def step(
        carry: tuple[Any, jax.Array], key: jax.Array
    ) -> tuple[tuple[Any, jax.Array], tuple[jax.Array, jax.Array]]:
        state, over = carry
        chosen, drawn = jax.random.split(key)
        actions = jax.random.randint(chosen, (env.num_agents,), 0, env.num_actions)
        _, state, reward, done, _ = env.step_env(drawn, state, actions)
        return (state, over | done), (reward.sum(), ~over)

    def episode(keys: jax.Array) -> tuple[jax.Array, jax.Array]:
        _, (rewards, lasts) = jax.lax.scan(
            step, (env.reset(keys[0])[1], jax.numpy.bool_(False)), keys[1:]
        )
        return rewards.sum(), lasts.sum()

    with jax.debug_key_reuse(False):  # it takes the parts of a split for the whole
        return tuple(
            map(
                np.asarray,
                jax.jit(jax.vmap(episode))(jax.random.split(jax.random.key(0), (episodes, 1001))),
            )
        )


@pytest.mark.thorough
@pytest.mark.parametrize("name", ORIGINAL["returns_of_random_play"])
def test_random_play_earns_what_it_earns_there(name: str) -> None:
    """Five standard errors of both means."""
    figures, entry = ORIGINAL["returns_of_random_play"][name], substrates()[name]
    returns, _ = random_play(entry.game, entry.variant or None, 64)
    assert abs(returns.mean() - figures["mean"]) < 5 * np.hypot(figures["error"], returns.std() / 8)


@pytest.mark.thorough
def test_one_shot_episodes_of_random_play_are_as_long() -> None:
    """Five standard errors of both means."""
    figures = ORIGINAL["length_of_random_play"]
    _, lengths = random_play("running_with_scissors_in_the_matrix", "one_shot", 121)
    assert abs(lengths.mean() - figures["mean"]) < 5 * np.hypot(
        figures["error"], lengths.std() / 11
    )
