"""What every program keeps to: shapes and dtypes, one agent a cell, whole episodes, one key one result; all of it as the interpreter says.

Three games are played, and with all tests every bundled game, variant and crowd, see `found` and `plays`; a run is one `jit` of a `vmap`
of a `scan` of `step`. `tests/differential/test_equal.py` plays all games for a few steps, on NumPy.
"""

from collections.abc import Iterator
from typing import Any

import jax
import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import Outcome, World
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.testing.engines import interpreter_params
from tests.differential.compare import Report, compare, compare_outcome
from tests.differential.worlds import world_of

from .environments import BRIEFLY, HARVESTS, NINE, environment, places
from .found import Form, programs, rules_of
from .plays import AFTER, Play, played

# number of actions and of agents. Source: the released code; the agents of Coop Mining, Gift, Mushrooms and PD as decided for this project
ACTIONS = {
    "coins": 7,
    **dict.fromkeys(HARVESTS, 8),
    "clean_up": 9,
    "coop_mining": 8,
    "gift_refinement": 9,
    "mushrooms": 8,
    "pd_arena": 8,
}
AGENTS = {
    "coins": 2,
    **dict.fromkeys(HARVESTS, 7),
    "clean_up": 7,
    "coop_mining": 6,
    "gift_refinement": 5,
    "mushrooms": 5,
    "pd_arena": 4,
}
HOMES = {
    "coins": "",
    **dict.fromkeys(HARVESTS, "P"),
    "clean_up": "P",
    "coop_mining": "",
    "gift_refinement": "",
    "pd_arena": "P",
}
TOGETHER = 10  # steps that both engines take from a start
SAMPLED = 6  # steps that both engines take from wherever a run has come to, beside those in which something is counted


USUAL = tuple(map(Form, ("coins", "clean_up", "pd_arena")))
SELDOM = (
    *map(Form, ("harvest_open", "coop_mining", "gift_refinement", "mushrooms")),
    Form("clean_up", "socialjax"),
)


def forms() -> list[Any]:
    """Returns three games, more with the thorough tests, and with all tests every program.

    To know which forms are programs of their own, all of them are built: that takes as long as playing the three.
    """
    thorough = [pytest.param(form, marks=pytest.mark.thorough) for form in SELDOM]
    if BRIEFLY:
        return [*USUAL, *thorough]
    others = [form for form in programs() if form not in USUAL + SELDOM]
    return [*USUAL, *thorough, *(pytest.param(form, marks=pytest.mark.slow) for form in others)]


@pytest.fixture(scope="module", params=forms(), ids=str)
def form(request: pytest.FixtureRequest) -> Form:
    """Of module scope, so that the tests of one form follow one another and share its runs."""
    return request.param


@pytest.mark.parametrize("game", NINE)
def test_description(game: str) -> None:
    env = environment(game)
    assert (env.name, env.num_agents, env.num_actions, env.episode_length) == (
        game,
        AGENTS[game],
        ACTIONS[game],
        1000,
    )
    assert env.action_names[:7] == (
        "turn_left",
        "turn_right",
        "step_left",
        "step_right",
        "forward",
        "backward",
        "stay",
    )
    assert env.observation_shape == (env.num_agents, len(env.token_planes), 11, 11)


def test_shapes_and_dtypes(form: Form) -> None:
    play = played(form)
    env, agents = play.env, play.env.num_agents
    both, steps = 2, play.env.episode_length + AFTER
    for seen, lead in (
        (play.reset_observation, ()),
        (play.observations, (both, steps)),
        (play.terminal, (both,)),
    ):
        assert (seen.shape, seen.dtype) == ((*lead, *env.observation_shape), np.uint8)
    assert (play.rewards.shape, play.rewards.dtype) == ((both, steps, agents), np.float32)
    for flag in (play.dones, play.infos["truncated"], play.infos["terminated"]):
        assert (flag.shape, flag.dtype) == ((both, steps), np.bool_)
    per_agent = {e.name for e in env.game.events if e.per_agent}
    names = [name for e in env.game.events for _, name in counts_of(e)]
    assert sorted(play.infos["events"]) == sorted(names)
    for name, value in play.infos["events"].items():
        assert (value.shape, value.dtype) == (
            (both, steps, agents) if name.split("[")[0] in per_agent else (both, steps),
            np.int32,
        )
    assert sorted(play.infos["metrics"]) == sorted(m.name for m in env.game.measures)
    for value in play.infos["metrics"].values():
        assert (value.shape, value.dtype) == ((both, steps), np.float32)
    assert np.isfinite(play.rewards).all()
    before, after = (jax.tree.map(lambda x: (x.shape, x.dtype), play.state(0, t)) for t in (0, 1))
    assert jax.tree.leaves(before) == jax.tree.leaves(after)


def test_an_episode_ends_after_its_steps(form: Form) -> None:
    """Truncated after exactly so many, and not terminated, unless the game has an `end`; then the next begins."""
    play = played(form)
    length = play.env.episode_length
    assert length == 1000 or form.game not in NINE
    if not any(isinstance(node, ir.End) for node in ir.walk(rules_of(form))):
        assert play.ends() == [length - 1] * 2
        assert not play.infos["terminated"].any()
    np.testing.assert_array_equal(play.dones, play.infos["truncated"] | play.infos["terminated"])
    assert not (play.infos["truncated"] & play.infos["terminated"]).any()
    for run, end in enumerate(play.ends()):
        assert end < length
        assert play.states.step[run, : end + 1].tolist() == [*range(1, end + 1), 0]
        assert play.states.step[run, end + 1] == 1


def test_one_agent_a_cell_and_none_where_agents_are_blocked(form: Form) -> None:
    play = played(form)
    rules = rules_of(form)
    where = places(play.env, play.states.position)
    here = play.states.position > 0
    rows, cols = len(rules.rows), len(rules.rows[0])
    assert ((where >= 0) & (where < (rows, cols))).all(axis=-1)[here].all()
    alone = np.where(
        here, where[..., 0] * cols + where[..., 1], -1 - np.arange(play.env.num_agents)
    )
    assert (np.diff(np.sort(alone, axis=-1), axis=-1) > 0).all()
    blocking = {
        kind.name
        for kind in rules.kinds
        for block in kind.blocks
        if block.what == "agents" and block.condition is None
    }
    blocked = np.isin(
        [list(row) for row in rules.rows], [g.glyph for g in rules.glyphs if g.kind in blocking]
    )
    assert not blocked[where[here][:, 0], where[here][:, 1]].any()
    if not any(
        isinstance(node, ir.Remove) or (isinstance(node, ir.Send) and node.after is not None)
        for node in ir.walk(rules)
    ):
        assert here.all()


def test_an_agent_goes_one_cell_or_home(form: Form) -> None:
    """Between two steps of an episode: no farther than a neighbour cell, but to where this game sends agents."""
    if form.game not in HOMES:
        pytest.skip("not one of the games whose homes are known here")
    play = played(form)
    for run, end in enumerate(play.ends()):
        where = places(play.env, play.states.position[run, :end])
        here = play.states.position[run, :end] > 0
        far = (
            (np.abs(np.diff(where, axis=0)).sum(axis=2) > 1) & here[1:] & here[:-1]
        )  # who comes back walks at once
        assert {play.env.game.rows[r][c] for r, c in where[1:][far]} <= set(HOMES[form.game])


def test_one_sees_oneself_in_the_window(form: Form) -> None:
    """In the cell where the window has it, and nowhere else; every plane holds values it has a meaning for."""
    play = played(form)
    window, names = play.env.game.window, [p.name for p in play.env.token_planes]
    own = play.observations[..., names.index("agent"), :, :] == 1
    here = play.states.position > 0
    assert (own[..., window.ahead, window.left] == here).all()
    assert own.sum() == here.sum()
    assert form.game not in NINE or (window.ahead, window.left) == (9, 5)
    for index, plane in enumerate(play.env.token_planes):
        most = {
            "word": len(plane.labels) - 1,
            "bits": 2 ** len(plane.labels) - 1,
            "number": plane.high,
        }[plane.encoding]
        assert play.observations[..., index, :, :].max() <= most


def test_uniform_planes_have_one_value_in_a_window(form: Form) -> None:
    """They are what is shown of the observer, of everyone and of the world."""
    play = played(form)
    of_world = {
        observable.field for observable in play.env.game.observables if observable.what == "world"
    }
    for index, plane in enumerate(play.env.token_planes):
        assert plane.uniform == (
            plane.name.startswith(("agent.", "everyone["))
            or plane.name.partition("[")[0] in of_world
        )
        values = play.observations[..., index, :, :]
        assert not plane.uniform or (values == values[..., :1, :1]).all()


def test_it_plays_as_the_interpreter_says(form: Form) -> None:
    """From the starts on; then from states of the whole episode, among them some before each of the events that came."""
    play = played(form)
    for run in (0, 1):
        world = started(play) if run == 0 else world_of(play.env, play.state(1, 0), given(play, 1))
        compared(play, run, 0, world, play.reset_observation if run == 0 else None)
        for t in range(TOGETHER):
            world = both_step(play, run, t, world)
        for t in steps_of_interest(play, run):
            both_step(play, run, t, world_of(play.env, play.state(run, t), given(play, run)))


def test_the_next_episode_starts_as_the_interpreter_says(form: Form) -> None:
    """With the key of the step that ended the last; what that step gave is paid, and what was seen at the end is handed over."""
    play = played(form)
    for run, end in enumerate(play.ends()):
        before = world_of(play.env, play.state(run, end), given(play, run))
        draws = Threefry(*play.words[end].tolist())
        world, outcome = step(
            play.env.game, before, play.actions[run, end].tolist(), given(play, run), draws
        )
        assert outcome.truncated or outcome.terminated
        assert_outcome(play, run, end, outcome)
        np.testing.assert_array_equal(play.terminal[run], observe(play.env.game, world))
        fresh = reset(play.env.game, given(play, run), Threefry(*play.words[end].tolist()))
        compared(play, run, end + 1, fresh, play.observations[run, end])


def test_the_same_keys_give_the_same_runs(form: Form) -> None:
    """Step by step and all at once: the run of a batch is that of each environment alone; another key gives another."""
    if form not in (
        Form("coins"),
        Form("clean_up"),
        Form("pd_arena", "socialjax"),
        Form("harvest_open", "meltingpot"),
    ):
        pytest.skip("some stand for all: the batch is one transformation of one function")
    play = played(form)
    params = jax.tree.map(lambda x: x[1], play.params)
    for t in (0, 1, play.ends()[1]):
        state, actions = play.state(1, t), play.actions[1, t]
        _, after, reward, done, info = play.env.step(
            jax.random.wrap_key_data(play.words[t]), state, actions, params
        )
        for mine, theirs in zip(
            jax.tree.leaves(after), jax.tree.leaves(play.state(1, t + 1)), strict=True
        ):
            np.testing.assert_array_equal(mine, theirs)
        np.testing.assert_array_equal(reward, play.rewards[1, t])
        assert bool(done) == play.dones[1, t]
        if done:
            np.testing.assert_array_equal(info["terminal_observation"], play.terminal[1])
    assert (
        len({tuple(play.env.reset(jax.random.key(seed))[1].position.tolist()) for seed in range(8)})
        > 1
    )


def started(play: Play) -> World:
    """Returns the interpreter's start of the own run."""
    return reset(play.env.game, given(play, 0), Threefry(*play.reset_words.tolist()))


def given(play: Play, run: int) -> dict[str, Any]:
    """Returns the parameters of a run as the interpreter has them."""
    return interpreter_params(play.env, jax.tree.map(lambda x: x[run], play.params))


def steps_of_interest(play: Play, run: int) -> list[int]:
    """Returns steps all over the episode, and for each event one early and one late in which it came."""
    end = play.ends()[run]

    def found() -> Iterator[int]:
        yield from np.linspace(TOGETHER, end - 1, SAMPLED).astype(int).tolist()
        for counts in play.infos["events"].values():
            came = np.flatnonzero(counts[run, :end].reshape(end, -1).any(axis=1))
            yield from came[[0, 2 * len(came) // 3]].tolist() if len(came) else ()

    return sorted(set(found()))


def both_step(play: Play, run: int, t: int, world: World) -> World:
    """Returns the interpreter's next world, which is the compiled one."""
    draws = Threefry(*play.words[t].tolist())
    world, outcome = step(
        play.env.game, world, play.actions[run, t].tolist(), given(play, run), draws
    )
    assert_outcome(play, run, t, outcome)
    compared(play, run, t + 1, world, play.observations[run, t])
    return world


def assert_outcome(play: Play, run: int, t: int, outcome: Outcome) -> None:
    """Asserts that rewards, events, metrics and endings of a step are the interpreter's."""
    report = Report()
    info = jax.tree.map(lambda x: x[run, t], play.infos)
    compare_outcome(play.env, play.rewards[run, t], play.dones[run, t], info, outcome, report)
    assert not report.differences, (run, t, report.differences)


def compared(play: Play, run: int, t: int, world: World, observation: Any) -> None:
    """Asserts that a state, and what is seen of it, is the interpreter's."""
    report = Report()
    seen = observe(play.env.game, world) if observation is None else observation
    compare(play.env, play.state(run, t), seen, world, report)
    assert not report.differences, (run, t, report.differences)
