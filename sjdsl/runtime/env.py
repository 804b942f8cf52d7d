"""The environment interface: reset, step and auto-reset of one compiled game, ready for `jit`, `vmap` and `scan`."""

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

State = Any
Params = Any
Info = dict[str, Any]
ALIKE = 8  # episodes that must begin with the same roles: chance roles of two agents would pass once in 2^7 games at most
Admit = Callable[[Params], Params]
Step = Callable[..., tuple[Array, State, Array, Array, Info]]
Encoding = Literal["tokens", "onehot"]  # of observations


class Environment:
    """One environment of a compiled game; `vmap` it for many.

    Attributes:
      name, title, hash: the game; two games share a hash if and only if their rules are equal.
      num_agents, num_actions, action_names, episode_length: as the rules have them.
      forbids_actions: whether `allowed_actions` is ever false: the game has a `forbid`.
      observation_shape: `(N, P, rows, cols)` for tokens, `(N, C, rows, cols)` for onehot; observation_dtype: uint8.
      token_planes: what each of the P planes means; channel_names: names of the C one-hot channels.
      params: the run-time parameters, a pytree; the defaults of `reset` and `step`.
      module: the generated code, or a namespace of its names; game: the typed rules (`sjdsl.compiler.ir.Game`) for tools that
        read them, None where there is no compiler. Playing reads the module alone.
    """

    def __init__(
        self,
        module: GameModule,
        params: Params,
        observation: Encoding = "tokens",
        game: Any = None,
        admit: Admit | None = None,
    ) -> None:
        """Raises ValueError for an observation that is neither `tokens` nor `onehot`. `admit`: checks the values given to `with_params`."""
        if observation not in ("tokens", "onehot"):
            raise ValueError(f"observation is `tokens` or `onehot`, not {observation!r}")
        self.module = module
        self.params = params
        self.observation = observation
        self.game = game
        self._admit = admit
        self.name, self.title, self.hash = module.NAME, module.TITLE, module.HASH
        self.num_agents, self.num_actions, self.action_names = (
            module.NUM_AGENTS,
            len(module.ACTIONS),
            module.ACTIONS,
        )
        self.forbids_actions = module.FORBIDS_ACTIONS
        self.token_planes, self.channel_names = (
            module.TOKEN_PLANES,
            channel_names(module.TOKEN_PLANES),
        )
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
    def episode_length(self) -> int:
        """Steps until truncation under `params`; also inside `jit`, where a number of the file would else be traced."""
        with jax.ensure_compile_time_eval():
            return int(self.module.episode_length(self.params))

    def with_params(self, params: Params) -> "Environment":
        """Returns the same game with other run-time parameters: arrays as in `env.params`, or Python's numbers.

        They may be traced, by `jax.vmap` for example; of these only shape and dtype are checked. In an environment of `make` all others are as
        `make(params=…)` takes them.

        Raises:
          TypeError: parameters of another game. ValueError: a shape or dtype that is not the parameter's, a value that the game does not take.
        """
        check_params(self.module, self.params, params)
        if self._admit is None:
            check_arrays(params, self.params)
        else:
            params = self._admit(params)
        return Environment(self.module, params, self.observation, self.game, self._admit)

    def _given(self, params: Params | None) -> Params:
        """Returns the parameters to play with. They are traced, mostly: their values are not looked at."""
        if params is None:
            return self.params
        check_params(self.module, self.params, params)
        check_arrays(params, self.params)
        return params

    def __reduce__(self) -> tuple[Any, ...]:
        """Lets it be copied and pickled: the compiled functions are made anew."""
        return Environment, (self.module, self.params, self.observation, self.game, self._admit)

    def __repr__(self) -> str:
        return f"<sjdsl.Environment {self.name} {self.hash}: {self.num_agents} agents, {self.num_actions} actions, {self.observation}>"

    def _reset(self, key: Array, params: Params | None = None) -> tuple[Array, State]:
        """Returns the first observation and state of an episode.

        Args:
          key: a typed key, or two uint32 words (old style).
          params: instead of `env.params`.
        Raises:
          TypeError, ValueError: something else than one key, or parameters of another game.
        """
        params = self._given(params)
        state = self.module.reset(params, key_words(key))
        return self._observe(state, params), state

    def _step(
        self, key: Array, state: State, actions: Array, params: Params | None = None
    ) -> tuple[Array, State, Array, Array, Info]:
        """One step; a finished episode is followed by the first state of the next.

        Args:
          key: consumed; the step's draws (and those of a reset) come from it alone.
          state: of `reset` or `step`.
          actions: `[N]` int, numbers of `action_names`; any other number of int32 is `stay`.
          params: instead of `env.params`.
        Returns:
          observation (of the state returned); state; reward `[N]` float32, raw; done bool; info: `truncated`, `terminated` bool,
          `events` int32 `[N]` or scalar counts of this step, `metrics` float32 scalars, `terminal_observation` and
          `terminal_state` (before the reset; they cost nothing under `jit` when unused).
        Raises:
          TypeError: actions are not whole numbers; a key, a state or parameters that are none of this game.
          ValueError: there is not one action for each agent, or one is beyond int32 (traced ones JAX cuts off to 32 bits before); a
            batch of keys or states.
        """
        params = self._given(params)
        words = key_words(key)
        ended, reward, done, info = self._transition(words, state, actions, params)
        state = reset_where(self.module.reset, done, words, params, ended)
        info["terminal_observation"] = self._observe(ended, params)
        info["terminal_state"] = ended
        return self._observe(state, params), state, reward, done, info

    def _step_env(
        self, key: Array, state: State, actions: Array, params: Params | None = None
    ) -> tuple[Array, State, Array, Array, Info]:
        """As `step`, without the reset."""
        params = self._given(params)
        state, reward, done, info = self._transition(key_words(key), state, actions, params)
        info["terminal_observation"] = observation = self._observe(state, params)
        info["terminal_state"] = state
        return observation, state, reward, done, info

    def _transition(
        self, words: Array, state: State, actions: Array, params: Params
    ) -> tuple[State, Array, Array, Info]:
        check_state(self.module, state)
        state, out = self.module.step(
            state, checked_actions(actions, self.num_agents), params, words
        )
        metrics = self.module.measures(state, params)
        state = state.replace(step=state.step + 1)
        truncated = (state.step >= self.module.episode_length(params)) & ~out.ended
        info = {
            "truncated": truncated,
            "terminated": out.ended,
            "events": self._events(out),
            "metrics": metrics,
        }
        return state, out.reward, truncated | out.ended, info

    def _events(self, out: Any) -> dict[str, Array]:
        """Returns the counts of a step by event; a `by` event gives `name[word]` for each word."""
        counts = (
            (name, getattr(out, attribute), entry) for name, attribute, entry in self.module.EVENTS
        )
        return {
            name: count if entry is None else count[..., entry] for name, count, entry in counts
        }

    def _observe(self, state: State, params: Params | None = None) -> Array:
        """Returns the observation of a state."""
        check_state(self.module, state)
        tokens = self._tokens(state, self._given(params))
        return (
            tokens
            if self.observation == "tokens"
            else to_channels(tokens, self.token_planes, jnp.dtype(jnp.uint8))
        )

    def allowed_actions(self, state: State, params: Params | None = None) -> Array:
        """Returns which actions each agent may take: `[N, A]` bool."""
        check_state(self.module, state)
        return self.module.allowed_actions(state, self._given(params))

    def state_vector(self, state: State, params: Params | None = None) -> Array:
        """Returns the whole state as `[K]` float32 from -1 to 1, for a central critic; what is in it: `runtime/state_vector.py`."""
        row, col = self.cells(state)
        return state_vector(
            self.module, state, row, col, self.module.episode_length(self._given(params))
        )

    @property
    def roles(self) -> tuple[int, ...] | None:
        """The role of each agent, as numbers from 0: a field of the agents called `role` that every episode begins with alike.

        None if there is no such field, or it changes: by a rule, or from episode to episode.
        """
        if self.module.ROLE is None:
            return None
        states = jax.vmap(lambda key: self.reset(key)[1])(
            jax.vmap(jax.random.key)(jnp.arange(ALIKE))
        )
        roles = np.asarray(getattr(states, self.module.ROLE))
        return tuple(int(role) for role in roles[0]) if (roles == roles[0]).all() else None

    def cells(self, state: State) -> tuple[Array, Array]:
        """Returns the (row, col) of each agent on the map, int32 `[N]` each; negative for those who are away."""
        _, cols = self.module.FRAME
        pad = self.module.PAD
        return state.position // cols - pad, state.position % cols - pad


def _refusing(step: Any) -> Step:
    """Returns a compiled step that refuses actions beyond int32."""

    @wraps(step)
    def refusing(key: Array, state: State, actions: Array, params: Params | None = None) -> Any:
        refuse_beyond_int32(actions)
        return step(key, state, actions, params)

    for name in (
        "lower",
        "trace",
        "eval_shape",
        "clear_cache",
    ):  # of a function that JAX has compiled
        setattr(refusing, name, getattr(step, name))
    return refusing
