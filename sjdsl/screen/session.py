"""An episode that a person plays or watches: interpreted at first, compiled as soon as the compiler is done."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Value, World, copied
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.render.moment import Moment, moment_of
from sjdsl.replay.recording import Recording
from sjdsl.trace.choices import OTHERS, Chosen
from sjdsl.trace.jax_random import fold_in, key_of

if TYPE_CHECKING:  # the interpreter needs no JAX
    from sjdsl.runtime.env import Environment


class Player(Protocol):
    """An episode of a seed, taken one step at a time."""

    @property
    def moment(self) -> Moment:
        """What is shown now."""

    @property
    def world(self) -> World:
        """The state, for policies of the file."""

    @property
    def seen(self) -> tuple[Any, Any]:
        """What the agents see, and the state it is seen of, for policies of the compiled game."""

    def step(self, actions: Sequence[int]) -> Moment:
        """Takes one step with an action for each agent."""


class Interpreted:
    """The episode of a seed on the interpreter: it needs no JAX and starts at once.

    State by state it is what `sjdsl.replay.EpisodePlayer` plays for the same seed and actions. `seen`: nothing, for policies of the compiled
    game are not asked here.
    """

    seen = (None, None)

    def __init__(self, game: ir.Game, params: Mapping[str, Value], seed: int) -> None:
        """Begins the episode. `params`: every parameter of the game, reals as float32."""
        self._game, self._params, self._key = game, params, key_of(seed)
        self.world = copied(reset(game, params, Threefry(*fold_in(self._key, 0))))
        self.moment = moment_of(game, self.world, [0.0] * game.agents.number)

    def step(self, actions: Sequence[int]) -> Moment:
        draws = Threefry(*fold_in(self._key, self.world.step + 1))
        self.world, outcome = step(self._game, self.world, actions, self._params, draws)
        returns = self.moment.snapshot.returns + np.array(outcome.reward, float)
        self.moment = moment_of(self._game, self.world, returns, actions, outcome)
        return self.moment


class Compiled:
    """The episode of a seed on the compiled game."""

    def __init__(self, env: "Environment", params: Mapping[str, Value], seed: int) -> None:
        """Begins the episode, with a step compiled. `params`: as the interpreter has them."""
        from sjdsl.replay.episode_player import EpisodePlayer

        self._env, self._params, self._player = env, params, EpisodePlayer(env, seed)
        EpisodePlayer(env, seed).step([0] * env.num_agents)  # JAX compiles it now, not at the first key
        self.moment = self._player.now()

    @property
    def world(self) -> World:
        from sjdsl.properties.state_conversion import world_of

        return replace(world_of(self._env, self._player.state), params=dict(self._params))

    @property
    def seen(self) -> tuple[Any, Any]:
        return self._player.observation, self._player.state

    def step(self, actions: Sequence[int]) -> Moment:
        self.moment = self._player.step(actions)
        return self.moment


Choose = Callable[[int, Player], Sequence[int]]  # number of the step from 0, who plays -> an action for each agent


@dataclass(frozen=True)
class Prepared:
    """What a session can go on with once a game is compiled. choose: who plays by a trained policy, where one was asked for."""

    player: Player
    choose: Choose | None = None


class Session:
    """One episode, and what was done in it.

    Attributes:
      player: what plays it now; actions: of every step so far; agent: who is steered, None for nobody; length: steps at most.
    """

    def __init__(self, player: Player, choose: Choose, agent: int | None, length: int) -> None:
        """`choose`: what everybody does, but for the agent that is steered. `length`: steps after which the session ends."""
        self.player, self.agent, self.length = player, agent, length
        self.actions: list[tuple[int, ...]] = []
        self._choose = choose

    @property
    def moment(self) -> Moment:
        return self.player.moment

    @property
    def is_over(self) -> bool:
        return self.moment.done or len(self.actions) >= self.length

    def step(self, own: int | None = None) -> Moment:
        """Takes one step. `own`: the action of the agent that is steered."""
        assert not self.is_over
        actions = list(self._choose(len(self.actions), self.player))
        if self.agent is not None and own is not None:
            actions[self.agent] = own
        self.actions.append(tuple(actions))
        return self.player.step(actions)

    def hand_over(self, player: Player, taken: int, choose: Choose | None = None) -> None:
        """Goes on with another player of the same episode, which has taken so many of the steps; it takes the rest first.

        `choose`: what everybody does from now on, if not as before.
        """
        for actions in self.actions[taken:]:
            player.step(actions)
        self.player = player
        self._choose = choose or self._choose

    def recording(self, environment: Mapping[str, Any], game_hash: str, seed: int) -> Recording:
        """Returns the episode so far. `environment`: the arguments of `sjdsl.make`; game_hash: of the rules."""
        actions, returns = [list(step) for step in self.actions], self.moment.snapshot.returns.tolist()
        return Recording(environment=dict(environment), hash=game_hash, seed=seed, actions=actions, returns=returns)


def choice_of(chosen: Chosen) -> Choose:
    """Returns who does what is known from the state alone, as `sjdsl.trace.choices` has it."""
    return lambda number, player: chosen(number, player.world)


def policy_choice(env: Any, policy: Any, seed: int) -> Choose:
    """Returns who follows a policy, from the first step of an episode on."""
    import jax

    from sjdsl.runtime.policy import take_actions, with_memory

    remembering = with_memory(policy)
    memory, act = remembering.start, jax.jit(partial(take_actions, env, remembering))
    key = jax.random.fold_in(jax.random.key(seed), OTHERS)

    def choose(number: int, player: Player) -> list[int]:
        nonlocal memory
        memory, actions = act(memory, jax.random.fold_in(key, number), *player.seen)
        return list(actions.tolist())

    return choose


def written_choice(actions: Sequence[Sequence[int]]) -> Choose:
    """Returns who does what was recorded."""
    return lambda number, _player: actions[number]
