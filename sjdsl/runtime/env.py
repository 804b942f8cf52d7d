"""The environment interface: reset and step of one compiled game, for `jit`, `vmap` and `scan`."""

from collections.abc import Callable
from functools import wraps
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.arguments import (
    check_arrays,
    check_params,
    check_state,
    checked_actions,
    refuse_beyond_int32,
)
from sjdsl.runtime.auto_reset import reset_where
from sjdsl.runtime.forms import in_one_form
from sjdsl.runtime.module import GameModule
from sjdsl.runtime.planes import channel_names
from sjdsl.runtime.random_bits import key_words
from sjdsl.runtime.state_vector import state_vector
from sjdsl.runtime.tokens import to_channels
from sjdsl.runtime.trials import begin_trial_where, has_trials, is_last_trial, steps_of_trial

State = Any
Params = Any
Info = dict[str, Any]
# Episodes that have to begin with the same roles. Roles of two agents that are drawn at random pass
# with a probability of 2^-7 at most.
NUM_STARTS = 8
Admit = Callable[[Params], Params]
Step = Callable[..., tuple[Array, State, Array, Array, Info]]
Encoding = Literal["tokens", "onehot"]  # of observations


class Environment:
    """One environment of a compiled game; `vmap` it for many.

    Attributes:
      name, title, hash: the game; two games share a hash if and only if their rules are equal.
      num_agents, num_actions, action_names, episode_length: as the rules have them.
      forbids_actions: whether `allowed_actions` is ever false: the game has a `forbid`.
      observation_shape: `(N, P, rows, cols)` for tokens, `(N, C, rows, cols)` for onehot.
      observation_dtype: uint8.
      token_planes: the meaning of each of the P planes; channel_names: of the C one-hot channels.
      params: the run-time parameters, a pytree; the defaults of `reset` and `step`.
      module: the generated code, or a namespace of its names, all that playing needs.
      game: the typed rules (`sjdsl.compiler.ir.Game`) for tools that read them, None without a
        compiler.
    """

    def __init__(
        self,
        module: GameModule,
        params: Params,
        observation: Encoding = "tokens",
        game: Any = None,
        admit: Admit | None = None,
    ) -> None:
        """Compiles nothing yet.

        Args:
          admit: checks the values that are passed to `with_params`.

        Raises:
          ValueError: `observation` is neither `tokens` nor `onehot`.
        """
        if observation not in ("tokens", "onehot"):
            raise ValueError(f"observation is `tokens` or `onehot`, not {observation!r}")
        self.module = module
        self.params = params
        self.observation = observation
        self.game = game
        self._admit = admit
        self.name = module.NAME
        self.title = module.TITLE
        self.hash = module.HASH
        self.num_agents = module.NUM_AGENTS
        self.num_actions = len(module.ACTIONS)
        self.action_names = module.ACTIONS
        self.forbids_actions = module.FORBIDS_ACTIONS
        self.token_planes = module.TOKEN_PLANES
        self.channel_names = channel_names(module.TOKEN_PLANES)
        depth = len(self.token_planes if observation == "tokens" else self.channel_names)
        self.observation_shape: tuple[int, int, int, int] = (self.num_agents, depth, *module.WINDOW)
        self.observation_dtype = np.dtype(np.uint8)
        self.reset: Callable[..., tuple[Array, State]] = jax.jit(in_one_form(self._reset))
        self.step: Step = _refusing(jax.jit(in_one_form(self._step)))
        self.step_env: Step = _refusing(jax.jit(in_one_form(self._step_env)))
        self.observe: Callable[..., Array] = jax.jit(in_one_form(self._observe))
        self._tokens: Callable[..., Array] = jax.jit(
            module.observe
        )  # one function of the program, however often a step observes

    @property
    def num_trials(self) -> int:
        """Trials of an episode; 1 in a game without trials."""
        return self.module.NUM_TRIALS if has_trials(self.module) else 1

    @property
    def tasks(self) -> Any:
        """Which tasks are played, as the argument `tasks` of `make`; None in a game without any.

        None too if it was made from a compiled module alone, which plays all tasks.
        """
        task = None if self.game is None else self.game.task
        return None if task is None else task.played

    @property
    def split(self) -> str:
        """The name of the split whose tasks are held out, if they are what is played; else ""."""
        task = None if self.game is None else self.game.task
        return "" if task is None else task.split

    @property
    def episode_length(self) -> int:
        """Steps until truncation under `params`, of all trials, as a number also inside `jit`."""
        with jax.ensure_compile_time_eval():
            return int(self.module.episode_length(self.params))

    def with_params(self, params: Params) -> "Environment":
        """Returns the same game with other run-time parameters.

        In an environment of `make`, values are checked as those of `make(params=…)`; of traced
        ones, only shape and dtype are.

        Args:
          params: arrays as in `env.params`, perhaps traced by `jax.vmap`, or Python's numbers.

        Raises:
          TypeError: they are parameters of another game.
          ValueError: a shape or dtype is wrong, or the game doesn't accept a value.
        """
        check_params(self.module, self.params, params)
        if self._admit is None:
            check_arrays(params, self.params)
        else:
            params = self._admit(params)
        return Environment(self.module, params, self.observation, self.game, self._admit)

    def _given(self, params: Params | None) -> Params:
        """Returns the parameters to play with, mostly traced ones, whose values aren't checked."""
        if params is None:
            return self.params
        check_params(self.module, self.params, params)
        check_arrays(params, self.params)
        return params

    def __reduce__(self) -> tuple[Any, ...]:
        """Lets it be copied and pickled, without the compiled functions."""
        return Environment, (self.module, self.params, self.observation, self.game, self._admit)

    def __repr__(self) -> str:
        return (
            f"<sjdsl.Environment {self.name} {self.hash}: {self.num_agents} agents, "
            f"{self.num_actions} actions, {self.observation}>"
        )

    def _reset(self, key: Array, params: Params | None = None) -> tuple[Array, State]:
        """Returns the first observation and state of an episode.

        Args:
          key: a typed key, or two uint32 words (old style).
          params: instead of `env.params`.

        Raises:
          TypeError, ValueError: `key` isn't one key, or these are parameters of another game.
        """
        params = self._given(params)
        state = self.module.reset(params, key_words(key))
        return self._observe(state, params), state

    def _step(
        self, key: Array, state: State, actions: Array, params: Params | None = None
    ) -> tuple[Array, State, Array, Array, Info]:
        """Takes one step; a finished episode is followed by the first state of the next.

        Args:
          key: consumed; all draws of the step, and of a reset, come from it.
          state: of `reset` or `step`.
          actions: `[N]` int, numbers of `action_names`; any other number of int32 is `stay`.
          params: instead of `env.params`.

        Returns:
          observation of the state returned; state; reward `[N]` float32 of the game; done bool;
          info: `truncated`, `terminated` bool, `events` int32 `[N]` or scalar counts of this step,
          `metrics` float32 scalars, `terminal_observation` and `terminal_state` (before the next
          episode or trial; they cost nothing under `jit` when unused). In a game with trials also
          `trial`, the number of the trial that this step was in, from 0, and `trial_ended` bool;
          after the last step of a trial, the state is the first of the next.

        Raises:
          TypeError: actions aren't whole numbers, or the key, the state or the parameters aren't
            those of this game.
          ValueError: there isn't one action for each agent; an action is beyond int32, unless it is
            traced; or there are several keys or states.
        """
        return self._advanced(key, state, actions, params, resets=True)

    def _step_env(
        self, key: Array, state: State, actions: Array, params: Params | None = None
    ) -> tuple[Array, State, Array, Array, Info]:
        """Does what `step` does, without the reset after an episode."""
        return self._advanced(key, state, actions, params, resets=False)

    def _advanced(
        self, key: Array, state: State, actions: Array, params: Params | None, resets: bool
    ) -> tuple[Array, State, Array, Array, Info]:
        """Returns what `step` does. resets: whether an episode that ended is followed by another."""
        params = self._given(params)
        words = key_words(key)
        ended, reward, done, info = self._transition(words, state, actions, params)
        state = ended
        if has_trials(self.module):
            is_over = info["trial_ended"] if resets else info["trial_ended"] & ~done
            is_last = done if resets else jnp.zeros((), bool)
            state = begin_trial_where(self.module, is_over, is_last, words, params, ended)
        elif resets:
            state = reset_where(self.module.reset, done, words, params, ended)
        info["terminal_observation"] = self._observe(ended, params)
        info["terminal_state"] = ended
        observation = info["terminal_observation"]
        if state is not ended:
            observation = self._observe(state, params)
        return observation, state, reward, done, info

    def _transition(
        self, words: Array, state: State, actions: Array, params: Params
    ) -> tuple[State, Array, Array, Info]:
        """Returns the state after a step without any reset, rewards `[N]`, done `[]` and info."""
        check_state(self.module, state)
        state, out = self.module.step(
            state, checked_actions(actions, self.num_agents), params, words
        )
        metrics = self.module.measures(state, params)
        state = state.replace(step=state.step + 1)
        truncated = (state.step >= steps_of_trial(self.module, params)) & ~out.ended
        terminated = out.ended
        info = {"events": self._events(out), "metrics": metrics}
        if has_trials(self.module):
            info |= {"trial": state.world_trial, "trial_ended": truncated | terminated}
            is_last = is_last_trial(self.module, state)
            truncated &= is_last
            terminated &= is_last
        info |= {"truncated": truncated, "terminated": terminated}
        return state, out.reward, truncated | terminated, info

    def _events(self, out: Any) -> dict[str, Array]:
        """Returns the counts of a step by event; of an indexed one, `name[entry]` of each entry."""
        counts: dict[str, Array] = {}
        for name, attribute, entry in self.module.EVENTS:
            count = getattr(out, attribute)
            counts[name] = count if entry is None else count[..., entry]
        return counts

    def _observe(self, state: State, params: Params | None = None) -> Array:
        """Returns the observation of a state."""
        check_state(self.module, state)
        tokens = self._tokens(state, self._given(params))
        if self.observation == "tokens":
            return tokens
        return to_channels(tokens, self.token_planes, jnp.dtype(jnp.uint8))

    def allowed_actions(self, state: State, params: Params | None = None) -> Array:
        """Returns which actions each agent may take: `[N, A]` bool."""
        check_state(self.module, state)
        return self.module.allowed_actions(state, self._given(params))

    def state_vector(self, state: State, params: Params | None = None) -> Array:
        """Returns the whole state as `[K]` float32 from -1 to 1, for a central critic.

        Its entries are described in `runtime/state_vector.py`.
        """
        row, col = self.cells(state)
        length = steps_of_trial(self.module, self._given(params))
        return state_vector(self.module, state, row, col, length)

    @property
    def roles(self) -> tuple[int, ...] | None:
        """The role of each agent, from 0: the values of the agents' field `role`.

        None if there is no such field, a rule changes it, or episodes begin with different roles.
        """
        if self.module.ROLE is None:
            return None
        keys = jax.vmap(jax.random.key)(jnp.arange(NUM_STARTS))
        _, states = jax.vmap(self.reset)(keys)
        roles = np.asarray(getattr(states, self.module.ROLE))
        if (roles != roles[0]).any():
            return None
        return tuple(int(role) for role in roles[0])

    def cells(self, state: State) -> tuple[Array, Array]:
        """Returns row and column of each agent, int32 `[N]` each, negative for those away."""
        _, cols = self.module.FRAME
        pad = self.module.PAD
        return state.position // cols - pad, state.position % cols - pad


def _refusing(step: Any) -> Step:
    """Returns a compiled step that refuses actions beyond int32."""

    @wraps(step)
    def refusing(key: Array, state: State, actions: Array, params: Params | None = None) -> Any:
        refuse_beyond_int32(actions)
        return step(key, state, actions, params)

    for name in ("lower", "trace", "eval_shape", "clear_cache"):  # methods of JAX's functions
        setattr(refusing, name, getattr(step, name))
    return refusing
