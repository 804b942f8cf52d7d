"""An episode that a person plays or watches: interpreted at first, compiled as soon as the compiler is done."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from sjdsl.replay.recording import Recording
from sjdsl.screen.display import Display
from sjdsl.trace.choices import OTHERS, Chosen


class Player(Protocol):
    """An episode of a seed, taken one step at a time."""

    @property
    def display(self) -> Display:
        """Of the moment."""

    @property
    def seen(self) -> tuple[Any, Any]:
        """What the agents see, and the state it is seen of, for policies of the compiled game."""

    def step(self, actions: Sequence[int]) -> Display:
        """Takes one step with an action for each agent."""


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
    def display(self) -> Display:
        return self.player.display

    @property
    def is_over(self) -> bool:
        return self.display.done or len(self.actions) >= self.length

    def step(self, own: int | None = None) -> Display:
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
        actions, returns = [list(step) for step in self.actions], list(self.display.returns)
        return Recording(environment=dict(environment), hash=game_hash, seed=seed, actions=actions, returns=returns)


def choice_of(chosen: Chosen) -> Choose:
    """Returns who does what is known from the state alone, as `sjdsl.trace.choices` has it."""
    return lambda number, player: chosen(number, player.display.world)


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
