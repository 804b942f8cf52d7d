"""What holds in every step of Coins, Harvest and Clean Up, whatever the agents do and wherever they begin."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from .environments import cells_of, environment, frame_cells, places

STEPS = 40
DIRECTIONS = np.array([(-1, 0), (0, 1), (1, 0), (0, -1)])
STEP_NAMES = ("forward", "step_right", "backward", "step_left")
TURN_LEFT, TURN_RIGHT = 0, 1
steady = settings(max_examples=25, deadline=None, derandomize=True, database=None)


@dataclass(frozen=True)
class Run:
    """A run: states before the first step and after each (`[STEPS + 1, ...]`), what was done and what came of it (`[STEPS, ...]`)."""

    states: Any
    actions: np.ndarray
    reward: np.ndarray
    events: dict[str, np.ndarray]
    metrics: dict[str, np.ndarray]


@dataclass(frozen=True)
class Start:
    """What a run is made of: `crowd` agents begin side by side, `few` of the cells are filled."""

    seed: int
    crowd: bool
    few: float
    actions: bytes
    zaps: bool
    step: int


@st.composite
def starts(draw: st.DrawFn, agents: int) -> Start:
    """Returns starts; the actions are drawn byte by byte, so that a failure shrinks to few."""
    return Start(
        seed=draw(st.integers(0, 2**32 - 1)),
        crowd=draw(st.booleans()),
        few=draw(st.sampled_from([0.0, 0.03, 0.3, 1.0])),
        actions=draw(st.binary(min_size=STEPS * agents, max_size=STEPS * agents)),
        zaps=draw(st.booleans()),
        step=draw(st.sampled_from([0, 20, 45, 300])),
    )


@cache
def player(game: str) -> Callable[..., Any]:
    env = environment(game)

    def play(key: jax.Array, state: Any, actions: jax.Array, params: Any) -> Any:
        def advance(state: Any, given: Any) -> Any:
            _, after, reward, _, info = env.step_env(given[0], state, given[1], params)
            return after, (after, reward, info["events"], info["metrics"])

        _, (states, *rest) = jax.lax.scan(advance, state, (jax.random.split(key, STEPS), actions))
        return jax.tree.map(lambda a, b: jnp.concatenate([a[None], b]), state, states), *rest

    return jax.jit(play)


def run(game: str, start: Start, field: str, params: Any) -> Run:
    """Returns a run from a reset state with one field's cells filled and agents put as the start says, a crowd around such a cell."""
    env = environment(game)
    random = np.random.default_rng(start.seed)
    _, state = env.reset(jax.random.key(start.seed))
    walkable = [(r, c) for r, row in enumerate(env.game.rows) for c, glyph in enumerate(row) if glyph != "#"]
    middle = random.choice(cells_of(env, field.split("_")[0]))
    distance = [abs(r - middle[0]) + abs(c - middle[1]) for r, c in walkable]
    order = np.argsort(distance, kind="stable") if start.crowd else random.permutation(len(walkable))
    where = [walkable[i] for i in random.permutation(order[: 3 * env.num_agents])[: env.num_agents]]
    values = getattr(state, field)
    filled = random.integers(1, 3 if field == "tile_coin" else 2, values.shape)
    state = state.replace(
        step=jnp.int32(start.step),
        position=jnp.asarray(frame_cells(env, where)),
        heading=jnp.asarray(random.integers(0, 4, env.num_agents), jnp.int32),
        **{field: jnp.asarray(np.where(random.random(values.shape) < start.few, filled, 0), jnp.uint8)},
    )
    actions = np.frombuffer(start.actions, np.uint8).reshape(STEPS, env.num_agents) % (env.num_actions + 1)
    if not start.zaps and "zap" in env.action_names:
        actions = np.where(actions == env.action_names.index("zap"), env.action_names.index("forward"), actions)
    found = player(game)(jax.random.key(start.seed), state, jnp.asarray(actions, jnp.int32), params)
    states, reward, events, metrics = jax.tree.map(np.asarray, found)
    return Run(states, actions, reward, events, metrics)


def standing(game: str, kind: str, run: Run) -> np.ndarray:
    """Returns for each state and cell of a kind whether an agent stands on it."""
    cells = frame_cells(environment(game), cells_of(environment(game), kind))
    return (run.states.position[:, :, None] == cells).any(axis=1)


def assert_moves(game: str, run: Run) -> None:
    """Agents turn as they choose, go the way they choose or stay, alone on their cell, unless they are sent home."""
    env = environment(game)
    where, heading = places(env, run.states.position), run.states.heading
    rows, cols = len(env.game.rows), len(env.game.rows[0])
    flat = np.sort(where[..., 0] * cols + where[..., 1], axis=1)
    assert (np.diff(flat, axis=1) > 0).all()
    assert ((where >= 0) & (where < (rows, cols))).all()
    gates = set(cells_of(env, "gate")) if "hits" in run.events else set()
    hit = run.events["hits"].sum(axis=1) if "hits" in run.events else np.zeros(STEPS, int)
    for t in range(STEPS):
        sent = 0
        for agent in range(env.num_agents):
            action = int(run.actions[t, agent])
            turned = (heading[t, agent] + (action == TURN_RIGHT) - (action == TURN_LEFT)) % 4
            stepped = where[t + 1, agent] - where[t, agent]
            name = env.action_names[action] if action < env.num_actions else "stay"
            ways = [DIRECTIONS[(turned + STEP_NAMES.index(name)) % 4].tolist()] if name in STEP_NAMES else []
            if heading[t + 1, agent] != turned or stepped.tolist() not in [[0, 0], *ways]:
                assert tuple(where[t + 1, agent].tolist()) in gates
                sent += 1
        assert sent <= hit[t]


@given(start=starts(agents=7), growing=st.booleans())
@steady
def test_harvest(start: Start, growing: bool) -> None:
    env = environment("harvest_open")
    rates = (1.0, 1.0, 1.0) if growing else (0.0, 0.0, 0.0)
    default = start.seed % 2 == 0
    params = env.params if default else env.params.replace(**dict(zip(("regrow_1", "regrow_2", "regrow_3"), map(jnp.float32, rates))))
    game = run("harvest_open", start, "soil_fruit", params)
    assert_moves("harvest_open", game)
    ripe, under = game.states.soil_fruit == 1, standing("harvest_open", "soil", game)
    cells = np.array(cells_of(env, "soil"))
    apart = ((cells[:, None] - cells[None]) ** 2).sum(axis=2)
    near = ripe.astype(int) @ ((apart > 0) & (apart <= 4))
    grown, gone = ~ripe[:-1] & ripe[1:], ripe[:-1] & ~ripe[1:]
    # apples come only beside apples and under nobody, and go only where an agent eats
    assert not (grown & ((near[:-1] == 0) | under[:-1])).any()
    assert not (ripe[1:] & under[1:]).any()
    eaten = game.events["eaten"]
    np.testing.assert_array_equal(game.reward, eaten)
    assert (eaten <= 1).all()
    assert (gone.sum(axis=1) <= eaten.sum(axis=1)).all()
    if not default and not growing:
        np.testing.assert_array_equal(gone.sum(axis=1), eaten.sum(axis=1))
        assert not grown.any()
    # collapse is for ever
    left = ripe.sum(axis=1)
    np.testing.assert_array_equal(game.metrics["apples_left"], left[1:])
    assert not left[np.maximum.accumulate(left == 0)].any()
    # who does not zap hits nobody
    assert not game.events["hits"][game.actions != env.action_names.index("zap")].any()
    if not start.zaps:
        assert not game.events["hits"].any()


@given(start=starts(agents=2))
@steady
def test_coins(start: Start) -> None:
    env = environment("coins")
    game = run("coins", start, "tile_coin", env.params.replace(spawn=jnp.float32(0.02)))
    assert_moves("coins", game)
    coin, under = game.states.tile_coin, standing("coins", "tile", game)
    own, other = game.events["own_coins"], game.events["other_coins"]
    np.testing.assert_array_equal(game.reward, own + other - 2 * other[:, ::-1])
    assert (own + other <= 1).all()
    before, after = coin[:-1], coin[1:]
    # a coin keeps its colour until an agent comes to its cell; none lies under an agent, none comes where one was
    assert ((after == before) | (before == 0) | ((after == 0) & under[1:])).all()
    assert not (after[under[1:]] > 0).any()
    assert not ((before == 0) & (after > 0) & under[:-1]).any()
    # what an agent takes is what lay where it is now (or came there in this step)
    cells = frame_cells(env, cells_of(env, "tile"))
    for t in range(STEPS):
        for agent in range(2):
            site = np.flatnonzero(cells == game.states.position[t + 1, agent])
            lay = int(before[t, site[0]]) if site.size else 0
            if lay or not site.size or under[t, site[0]]:
                assert (own[t, agent], other[t, agent]) == (lay == agent + 1, lay == 2 - agent)


@given(start=starts(agents=7), quick=st.booleans())
@steady
def test_clean_up(start: Start, quick: bool) -> None:
    env = environment("clean_up")
    params = env.params.replace(best_rate=jnp.float32(0.5), pollution=jnp.float32(1)) if quick else env.params
    game = run("clean_up", start, "water_state", params)
    assert_moves("clean_up", game)
    dirty, ripe = game.states.water_state == 1, game.states.orchard_fruit == 1
    assert dirty.shape == (STEPS + 1, 147)
    assert (game.states.water_state <= 1).all()
    np.testing.assert_array_equal(game.metrics["clean_water"], 147 - dirty[1:].sum(axis=1))
    # new dirt: one cell a step at most, none before the step 50
    fresh, cleaned = ~dirty[:-1] & dirty[1:], dirty[:-1] & ~dirty[1:]
    step = game.states.step[:-1]
    np.testing.assert_array_equal(game.states.step, start.step + np.arange(STEPS + 1))
    assert (fresh.sum(axis=1) <= 1).all()
    assert not fresh[step < 50].any()
    # only cleaners clean, at most four cells each, and only in front of them
    count = game.events["cleaned"]
    cleans = game.actions == env.action_names.index("clean")
    assert not count[~cleans].any()
    assert (count <= 4).all()
    assert (cleaned.sum(axis=1) <= count.sum(axis=1)).all()
    water = np.array(cells_of(env, "water"))
    where, heading = places(env, game.states.position)[1:], game.states.heading[1:]
    if not start.zaps:
        ahead, right = DIRECTIONS[heading], DIRECTIONS[(heading + 1) % 4]
        beam = np.stack([where + ahead, where + 2 * ahead, where + ahead + right, where + ahead - right], axis=2)
        hit = (beam[:, :, :, None] == water).all(axis=-1) & cleans[:, :, None, None]
        reached = hit.any(axis=(1, 2))
        assert not (dirty[1:] & reached).any()
        assert not (cleaned & ~reached).any()
        came = (count - (hit & dirty[:-1, None, None]).sum(axis=(2, 3))).max(axis=1, initial=0)
        assert ((came == 0) | ((step >= 50) & (came == 1))).all()  # one of them may have become dirty in this very step
    # apples: only in a river that is clean enough, under nobody, one reward for each that is eaten
    grown, under = ~ripe[:-1] & ripe[1:], standing("clean_up", "orchard", game)
    spoiled = dirty[:-1].sum(axis=1) / 167 >= 0.4
    assert not (grown & (spoiled[:, None] | under[:-1])).any()
    assert not (ripe[1:] & under[1:]).any()
    np.testing.assert_array_equal(game.reward, game.events["eaten"])
    assert ((ripe[:-1] & ~ripe[1:]).sum(axis=1) <= game.reward.sum(axis=1)).all()
