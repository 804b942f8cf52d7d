"""A session: the interpreter's episode is the compiled game's, draw by draw, so that nothing jumps where one takes over from the other."""

from pathlib import Path

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from sjdsl.policies.compiled import scripted_policy
from sjdsl.render import Moment, random_policy
from sjdsl.runtime.env import Environment
from sjdsl.screen.session import Compiled, Interpreted, Session, choice_of, policy_choice
from sjdsl.trace.choices import random_actions, scripted_actions
from sjdsl.trace.jax_random import fold_in, key_of
from tests.screen.conftest import ORCHARD, Begin

CASES = Path(__file__).parents[1] / "cases"
FORWARD, STAY, SING = 2, 3, 4
SEED = 2**31 + 5


@pytest.fixture(scope="module")
def env() -> Environment:
    return sjdsl.make(ORCHARD)


def alike(first: Moment, second: Moment) -> bool:
    """Returns whether two moments show the same."""
    ours, theirs = ({**vars(m), **vars(m.snapshot)} for m in (first, second))
    common = ours["values"].keys() & theirs["values"].keys()  # the compiled state has more than the fields of the game
    for moment in (ours, theirs):
        moment |= {"snapshot": 0, "values": {name: moment["values"][name] for name in common}}
    assert len(common) > 1
    return jax.tree.all(jax.tree.map(lambda a, b: np.array_equal(np.asarray(a, float), np.asarray(b, float)), ours, theirs))


def test_keys_are_folded_as_jax_folds_them() -> None:
    for seed in (0, 7, SEED):
        for number in (0, 1, 1000, 2**32 - 1):
            found = jax.random.key_data(jax.random.fold_in(jax.random.key(seed), np.uint32(number)))
            assert fold_in(key_of(seed), number) == tuple(int(word) for word in found)


@pytest.mark.parametrize("game", [ORCHARD, "clean_up", "coins", CASES / "moving.sj"], ids=str)
def test_the_interpreter_plays_the_episode_of_the_compiled_game(game: str | Path) -> None:
    env = sjdsl.make(game)
    params = default_params(env.game)
    session, player = (
        Session(Interpreted(env.game, params, SEED), choice_of(random_actions(env.game, SEED)), None, 12),
        Compiled(env, params, SEED),
    )
    assert alike(session.moment, player.moment)
    while not session.is_over:
        assert alike(session.step(), player.step(session.actions[-1]))
    assert game != ORCHARD or (session.moment.done and session.moment.snapshot.returns.sum() > 0), "something happened"


def test_the_others_draw_what_the_random_policy_draws(orchard: ir.Game, env: Environment) -> None:
    ours, theirs = choice_of(random_actions(orchard, SEED)), policy_choice(env, random_policy(env), SEED)
    player = Compiled(env, default_params(orchard), 0)
    assert [list(ours(number, player)) for number in range(20)] == [theirs(number, player) for number in range(20)]


def test_the_others_follow_a_policy_of_the_file_as_the_compiled_game_does(orchard: ir.Game, env: Environment) -> None:
    """Draw by draw."""
    ours, theirs = choice_of(scripted_actions(orchard, "eater", SEED)), policy_choice(env, scripted_policy(env, "eater"), SEED)
    player, chosen = Compiled(env, default_params(orchard), SEED), set()
    for number in range(12):
        actions = ours(number, player)
        assert list(actions) == theirs(number, player)
        chosen |= set(actions)
        player.step(actions)
    assert len(chosen) > 2


@pytest.mark.parametrize("before", [0, 3])
def test_nothing_jumps_where_the_compiled_game_takes_over(begin: Begin, orchard: ir.Game, env: Environment, before: int) -> None:
    """Two sessions with the same keys, one of them handed over in the middle, while a step more was taken than was known."""
    keys = [SING, STAY, FORWARD, FORWARD, SING, STAY, FORWARD]
    whole, handed = begin(SEED, at_random=True), begin(SEED, at_random=True)
    for number, key in enumerate(keys):
        whole.step(key)
        handed.step(key)
        if number == before + 1:
            player = Compiled(env, default_params(orchard), SEED)
            for actions in handed.actions[:before]:
                player.step(actions)
            handed.hand_over(player, before)
        assert alike(handed.moment, whole.moment)
    assert isinstance(handed.player, Compiled)
    assert handed.recording({}, env.hash, SEED) == whole.recording({}, env.hash, SEED)


def test_a_session_ends_with_the_episode_or_its_steps(begin: Begin) -> None:
    for asked, taken in ((4, 4), (12, 12)):
        session = begin(steps=asked)
        while not session.is_over:
            session.step(FORWARD)
        assert len(session.actions) == taken
        assert session.moment.done == (taken == 12)
