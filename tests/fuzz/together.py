"""One game on the interpreter and, as compiled, on NumPy or JAX: the same keys and actions, compared after every step."""

import random
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.emit.module import render
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import body_types
from sjdsl.compiler.lower import lower
from sjdsl.compiler.lower.pools import all_pools
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Outcome, World, default_params
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.runtime.env import Environment
from sjdsl.runtime.trials import has_trials, is_last_trial, steps_of_trial
from tests.differential.compare import Report, compare, compare_outcome
from tests.fuzz import numpy_jax

Words = tuple[int, int]
FAR = 1e5  # real numbers of a state
ROUNDED = 1e-5  # random rules give dozens of rewards of both signs at once, and the order of additions is open


@dataclass(frozen=True)
class Play:
    """What is played: the key of the reset, and for every step its key and the actions."""

    start: Words
    keys: list[Words]
    actions: list[list[int]]


@dataclass(frozen=True)
class Moment:
    """One step. `ended`: the state after it; `world`: the one the next step begins with; `mask`: the actions allowed before it."""

    mask: list[list[bool]]
    ended: World
    outcome: Outcome
    world: World


@dataclass
class History:
    """What the interpreter does, until a real number runs away.

    Of reals that decide nothing additions round in any order (docs/semantics.md), and a rule that multiplies what it adds multiplies that
    error as well.
    """

    first: World
    moments: list[Moment] = field(default_factory=list)


def random_play(game: ir.Game, seed: int, steps: int) -> Play:
    """Returns a play with random actions, one number too many on each side: unknown ones are `stay`."""
    chance = random.Random(seed)
    keys = [(chance.getrandbits(32), chance.getrandbits(32)) for _ in range(steps + 1)]
    most = len(game.agents.actions)
    actions = [[chance.randint(-1, most) for _ in range(game.agents.number)] for _ in range(steps)]
    return Play(keys[0], keys[1:], actions)


def interpret(game: ir.Game, play: Play) -> History:
    """Returns the trajectory of a play by the interpreter; an episode that is over begins anew."""
    given = default_params(game)
    world = reset(game, given, Threefry(*play.start))
    history = History(world)
    for words, actions in zip(play.keys, play.actions, strict=True):
        draws = Threefry(*words)
        mask = action_mask(game, world)
        try:
            ended, outcome = step(game, world, actions, given, draws)
        except LeavesFloat32:
            break
        world = reset(game, given, draws) if outcome.terminated or outcome.truncated else ended
        if runs_away(ended):
            break
        history.moments.append(Moment(mask, ended, outcome, world))
    return history


def runs_away(world: World) -> bool:
    """Returns whether a real number of the state is beyond `FAR`."""
    return any(
        abs(x) > FAR or np.isnan(x) for x in _reals([world.fields, world.agents, world.cells])
    )


def _reals(values: Any) -> Iterator[Any]:
    if isinstance(values, dict):
        values = list(values.values())
    if isinstance(values, list | tuple):
        for value in values:
            yield from _reals(value)
    elif isinstance(values, float | np.floating):
        yield values


class OnNumPy(Environment):
    """A compiled game whose module runs on NumPy: steps and resets, with keys as two words."""

    def __init__(self, game: ir.Game, module: ModuleType):
        super().__init__(module, module.default_params(), game=game)
        self.pools = [
            f"{pool.phase} {pool.send.pool}" for pools in all_pools(game).values() for pool in pools
        ]
        self._tokens = module.observe  # not jitted

    def begin(self, words: Words) -> Any:
        return self.module.reset(self.params, key_of(words))

    def advance(self, words: Words, state: Any, actions: list[int]) -> Any:
        state, out = self.module.step(
            state, numpy_jax.as_array(actions, np.int32), self.params, key_of(words)
        )
        metrics = self.module.measures(state, self.params)
        state = state.replace(step=state.step + 1)
        is_over = (state.step >= steps_of_trial(self.module, self.params)) | out.ended
        info = {"events": self._events(out), "metrics": metrics}
        done = is_over
        if has_trials(self.module):
            info["trial_ended"] = is_over
            done = is_over & is_last_trial(self.module, state)
            if is_over and not done:
                state = self.module.next_trial(state, done, self.params, key_of(words))
        info |= {"truncated": done & ~out.ended, "terminated": done & out.ended}
        return state, out.reward, done, info


def key_of(words: Words) -> Any:
    return numpy_jax.as_array(words, np.uint32)


def module_text(game: ir.Game) -> str:
    return render(lower(game, f"{game.name}.sj"))


def on_numpy(game: ir.Game) -> OnNumPy:
    """Returns the environment of a game, compiled."""
    return of_text(game, module_text(game))


def of_text(game: ir.Game, text: str) -> OnNumPy:
    """Returns the environment of a game with this module."""
    return OnNumPy(game, numpy_jax.load(text, game.name))


def run(env: OnNumPy, play: Play, history: History) -> Report:
    """Returns how far the module on NumPy and the interpreter went together."""
    report = Report()
    for number, (state, observation, mask, step_) in enumerate(
        moments(env, play, len(history.moments))
    ):
        if step_ is None:
            compare(env, state, observation, history.first, report, ROUNDED)
        else:
            moment = history.moments[number - 1]
            _same("allowed", mask, moment.mask, report)
            compare(env, state, observation, moment.ended, report, ROUNDED)
            compare_outcome(env, *step_, moment.outcome, report, ROUNDED)
            report.steps += 1
        if report.differences:
            report.differences = [f"step {report.steps - 1}: {d}" for d in report.differences]
            break
    return report


def plain(env: OnNumPy, state: Any) -> dict[str, Any]:
    """Returns a state by name, without numbers that depend on what other rules there are.

    Places are rows and columns, as the numbers of cells depend on how far the shapes that are used reach. Who comes back has the phase and
    number of its destination, as destinations are counted through the game.
    """
    (_, cols), pad = env.module.FRAME, env.module.PAD
    positions = [attribute_of("position", sort) for sort in body_types(env.game)]
    values = {
        n: v for n, v in vars(state).items() if n not in positions and not n.startswith("mark_")
    }
    places = {n: np.asarray(getattr(state, n)) for n in positions if hasattr(state, n)}
    for sort in body_types(env.game):
        name, ticks = attribute_of("away_pool", sort), values.get(attribute_of("away", sort))
        if name in values and ticks is not None:
            values[name] = [
                env.pools[int(pool)] if back else ""
                for pool, back in zip(values[name], np.asarray(ticks), strict=True)
            ]
    return values | {
        n: np.where(at != 0, np.stack([at // cols - pad, at % cols - pad]), -1)
        for n, at in places.items()
    }


def moments(env: OnNumPy, play: Play, steps: int) -> Iterator[Any]:
    """Yields (state, observation, actions allowed before the step, (reward, done, info)) of the reset and of each step on NumPy."""
    with np.errstate(all="ignore"):  # what a guard protects is computed and not used
        state = env.begin(play.start)
        yield state, env._observe(state), None, None
        for words, actions in zip(play.keys[:steps], play.actions, strict=False):
            mask = np.asarray(env.module.allowed_actions(state, env.params)).tolist()
            ended, reward, done, info = env.advance(words, state, actions)
            yield ended, env._observe(ended), mask, (reward, done, info)
            state = env.begin(words) if done else ended


def jitted(env: Environment, plays: list[Play], histories: list[History]) -> list[str]:
    """Returns the differences of some plays at once on JAX: a batch of steps that begin anew, scanned, in one compilation."""
    starts, keys, actions = (
        jnp.asarray(x, t)
        for x, t in zip(_stacked(plays), (jnp.uint32, jnp.uint32, jnp.int32), strict=True)
    )

    def one(start: jax.Array, keys: jax.Array, actions: jax.Array) -> Any:
        first = env._reset(start)

        def advance(state: Any, given: Any) -> Any:
            observation, state, reward, done, info = env._step(given[0], state, given[1])
            return state, (observation, state, reward, done, info)

        return first, jax.lax.scan(advance, first[1], (keys, actions))[1]

    first, trajectory = jax.tree.map(np.asarray, jax.jit(jax.vmap(one))(starts, keys, actions))
    found = []
    for number, history in enumerate(histories):
        report = Report()
        take = lambda tree, *at: jax.tree.map(lambda x: x[(number, *at)], tree)  # noqa: B023, E731
        compare(env, take(first[1]), take(first[0]), history.first, report, ROUNDED)
        for t, moment in enumerate(history.moments):
            observation, state, reward, done, info = take(trajectory, t)
            compare(env, state, observation, moment.world, report, ROUNDED)
            compare_outcome(env, reward, done, info, moment.outcome, report, ROUNDED)
            if report.differences:
                found += [f"play {number}, step {t}: {d}" for d in report.differences]
                break
    return found


def _stacked(plays: list[Play]) -> tuple[Any, Any, Any]:
    return [p.start for p in plays], [p.keys for p in plays], [p.actions for p in plays]


def forms(env: Environment) -> list[str]:
    """Returns where tracing with strict dtypes and ranks fails, or a step changes the dtypes or shapes of the state."""
    key = jax.ShapeDtypeStruct((2,), jnp.uint32)
    with jax.numpy_dtype_promotion("strict"), jax.numpy_rank_promotion("raise"):
        before = jax.eval_shape(env._reset, key)[1]
        actions = jax.ShapeDtypeStruct((env.num_agents,), jnp.int32)
        after = jax.eval_shape(env._step_env, key, before, actions)[1]
        jax.eval_shape(env.allowed_actions, before)
    declared = jax.eval_shape(env.module.initial_state)
    shown = [
        {n: f"{v.dtype}{v.shape}" for n, v in vars(s).items()} for s in (declared, before, after)
    ]
    return [
        f"{n} is {', then '.join(s[n] for s in shown)}"
        for n in shown[0]
        if len({s[n] for s in shown}) > 1
    ]


def _same(name: str, mine: Any, theirs: Any, report: Report) -> None:
    if mine != theirs:
        report.differences.append(f"{name}: {mine} / {theirs}")
