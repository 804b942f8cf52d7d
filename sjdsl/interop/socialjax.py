"""SocialJax adapter: compiled games under the released suite's names, with its calls, scales and orders."""

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from flax import struct
from jax import Array

from sjdsl.interop.copies import Copied
from sjdsl.interop.socialjax_observation import make_channels
from sjdsl.interop.socialjax_rewards import Mode, make_rewards
from sjdsl.interop.socialjax_table import Entry, Figure, entries
from sjdsl.interop.spaces import make_box, make_discrete
from sjdsl.library.factory import make as make_game
from sjdsl.render.look import make_look
from sjdsl.render.moment import take_snapshot
from sjdsl.runtime.arguments import checked_actions

# the suite's compass is turned round: `left` increases the column, `up` the row
ACTIONS = {"turned round": (0, 1, 3, 2, 5, 4), "as ours": (0, 1, 2, 3, 4, 5)}
VARIANT = "socialjax"


@struct.dataclass
class State:
    """The state of the game, and the suite's counters: steps in this episode, episodes so far. frame: see `agent_locs`."""

    game: Any
    inner_t: Array
    outer_t: Array
    frame: tuple[int, int, bool] = struct.field(
        pytree_node=False
    )  # columns of the board, its border, whether the compass is turned

    @property
    def agent_locs(self) -> Array:
        """Where the agents are, `[N, 3]` int32: row, column, heading by the suite's count, from 0 for its `up`, clockwise on its screen."""
        cols, border, turned = self.frame
        row, col = jnp.divmod(self.game.position.astype(jnp.int32), cols)
        heading = self.game.heading.astype(jnp.int32)
        return jnp.stack(
            [row - border, col - border, (2 - heading) % 4 if turned else heading], axis=-1
        )


class SocialJaxGame(Copied):
    """One environment: integer agents, `[N, rows, cols, channels]` float32 observations, rewards `[N]`, dones by "0", "1", … and "__all__".

    Attributes:
      agents: 0, 1, …; num_agents; env: the `sjdsl.Environment`; name; observation_spaces, action_spaces: empty, as those of the
        suite's environments are, which its `CTRolloutManager` asks for.
    """

    def __init__(
        self,
        entry: Entry,
        mode: Mode,
        num_inner_steps: int,
        num_outer_steps: int,
        cnn: bool,
        **arguments: Any,
    ) -> None:
        """Use `make`."""
        self.env = make_game(entry.game, VARIANT, observation="onehot", **arguments)
        self.num_agents = self.env.num_agents
        self.agents = list(range(self.num_agents))
        self.num_inner_steps, self.num_outer_steps = num_inner_steps, num_outer_steps
        self.observation_spaces: dict[str, Any] = {}
        self.action_spaces: dict[str, Any] = {}
        self._info, self._flat = entry.info, not cnn
        self._frame = (
            self.env.module.FRAME[1],
            self.env.module.PAD,
            entry.compass == "turned round",
        )
        depth, self._channels = make_channels(self.env, entry)
        self._rewards = make_rewards(mode, self.num_agents, entry.scaled, entry.shared)
        kind = "shaped" if mode.inequity_aversion or mode.svo or mode.interest else "alone"
        self._scale = (
            self.num_agents if kind in entry.scaled and not mode.shared_rewards else 1
        )  # of an agent's own reward, before shaping
        moves = ACTIONS[entry.compass]
        self._actions = jnp.asarray([*moves, *range(len(moves), self.env.num_actions)], jnp.int32)
        rows, cols = self.env.observation_shape[2:]
        self._shape = (rows * cols * depth,) if self._flat else (rows, cols, depth)

    @property
    def name(self) -> str:
        """The game's name."""
        return self.env.name

    @property
    def action_names(self) -> tuple[str, ...]:
        """The names of the suite's actions, by their effect on our map."""
        return tuple(self.env.action_names[number] for number in self._actions.tolist())

    def observation_space(self, agent: int | str | None = None) -> tuple[Any, tuple[int, ...]]:
        """Returns the space of an agent and its shape, a pair as in the suite; all agents have the same."""
        del agent
        return make_box(0.0, 255.0, self._shape), self._shape

    def action_space(self, agent: int | str | None = None) -> Any:
        """Returns the space of an agent; all agents have the same."""
        del agent
        return make_discrete(self.env.num_actions)

    @partial(jax.jit, static_argnums=(0,))
    def reset(self, key: Array) -> tuple[Array, State]:
        """Returns the first observations and state."""
        observation, game = self.env.reset(key)
        return self._observation(observation), State(game, jnp.int32(0), jnp.int32(0), self._frame)

    @partial(jax.jit, static_argnums=(0,))
    def step(
        self,
        key: Array,
        state: State,
        actions: Sequence[Array] | Array,
        timestep: Any = 0,
        reset_state: State | None = None,
    ) -> tuple[Array, State, Array, dict[str, Array], dict[str, Array]]:
        """Plays one step; after the last episode, returns the first state of the next, or `reset_state`.

        Args:
          actions: N numbers or arrays of shape `()` or `(1,)`, in the order of `agents`.
          timestep: the time step of the training, for a schedule of reward exchange.
        """
        observation, game, reward, ended, info = self.env.step(
            key, state.game, self._our_actions(actions)
        )
        made = self._after(state, game, ended)
        over = made.outer_t >= self.num_outer_steps
        made = replace(made, outer_t=jnp.where(over, 0, made.outer_t))
        if reset_state is not None:
            made = jax.tree.map(lambda new, old: jnp.where(over, new, old), reset_state, made)
            observation = self.env.observe(made.game)
        return (
            self._observation(observation),
            made,
            *self._results(reward, over, info, actions, timestep),
        )

    @partial(jax.jit, static_argnums=(0,))
    def step_env(
        self, key: Array, state: State, actions: Sequence[Array] | Array, timestep: Any = 0
    ) -> tuple[Array, State, Array, dict[str, Array], dict[str, Array]]:
        """As `step`, but keeps the last state of the last episode."""
        _, game, reward, ended, info = self.env.step(key, state.game, self._our_actions(actions))
        made = self._after(state, game, ended)
        over = made.outer_t >= self.num_outer_steps
        made = replace(
            made,
            game=jax.tree.map(
                lambda last, new: jnp.where(over, last, new), info["terminal_state"], game
            ),
        )
        return (
            self._observation(self.env.observe(made.game)),
            made,
            *self._results(reward, over, info, actions, timestep),
        )

    def get_obs(self, state: State) -> Array:
        """Returns the observations of a state."""
        return self._observation(self.env.observe(state.game))

    def render(self, state: State) -> Any:
        """Returns the board as a picture, `[height, width, 3]` uint8."""
        import numpy as np

        from sjdsl.render.board import draw_board

        return draw_board(
            make_look(self.env.game), take_snapshot(self.env, state.game, np.zeros(self.num_agents))
        )

    def _our_actions(self, actions: Sequence[Array] | Array) -> Array:
        """Returns the action numbers of our game; numbers out of range have no effect, as in the suite."""
        given = self._stacked(actions)
        known = (given >= 0) & (given < self.env.num_actions)
        return jnp.where(known, self._actions[jnp.where(known, given, 0)], -1)

    def _stacked(self, actions: Sequence[Array] | Array) -> Array:
        return checked_actions(
            jnp.stack([jnp.reshape(action, ()) for action in actions]), self.num_agents
        )

    def _after(self, state: State, game: Any, ended: Array) -> State:
        return State(
            game,
            jnp.where(ended, 0, state.inner_t + 1),
            state.outer_t + ended.astype(jnp.int32),
            self._frame,
        )

    def _observation(self, observation: Array) -> Array:
        channels = self._channels(observation)
        return channels.reshape(self.num_agents, -1) if self._flat else channels

    def _results(
        self, raw: Array, done: Array, info: dict[str, Any], actions: Any, timestep: Any
    ) -> tuple[Array, dict[str, Array], dict[str, Array]]:
        rewards, further = self._rewards(raw, timestep)
        infos = {"original_rewards": self._scale * raw, "shaped_rewards": rewards, **further}
        infos |= {name: self._figure(figure, info, actions) for name, figure in self._info.items()}
        return rewards, {**{str(agent): done for agent in self.agents}, "__all__": done}, infos

    def _figure(self, figure: Figure, info: dict[str, Any], actions: Any) -> Array:
        if figure.action is not None:
            number = self.action_names.index(figure.action)
            return (self._stacked(actions) == number).astype(jnp.float32)
        counts = {**info["metrics"], **info["events"]}
        value = jnp.asarray(counts[figure.of], jnp.float32)
        value = value.sum() if figure.sum else value
        known = {"agents": self.num_agents, "steps": self.num_inner_steps}
        for factor in figure.times:
            value = value * (
                factor
                if isinstance(factor, int)
                else known[factor]
                if factor in known
                else getattr(self.env.params, factor)
            )
        return jnp.broadcast_to(value, (self.num_agents,))


def make(env_id: str, **kwargs: Any) -> SocialJaxGame:
    """Returns a game by the suite's id, with its keyword arguments.

    Args:
      env_id: one of `registered_envs`.
      kwargs: `num_agents`, `num_inner_steps` (1000; lb_foraging 100), `num_outer_steps` (1), `cnn`, `jit`, `obs_size` (11; lb_foraging's
        is `sight`, 8), `map_ASCII`, those that choose the reward (`socialjax_rewards.Mode`), and the game's own.
    Raises:
      ValueError: an unknown id or value. TypeError: an unknown keyword. Both messages list the known ones.
    """
    if env_id not in entries():
        raise ValueError(f"there is no id `{env_id}`; the ids are {', '.join(entries())}")
    entry, given = entries()[env_id], dict(kwargs)
    modes = {field.name for field in fields(Mode)}
    window, side = entry.window
    known = {*modes, *entry.kwargs, *COMMON, window} | ({"map_ASCII"} if entry.letters else set())
    unknown = sorted(set(given) - known)
    if unknown:
        raise TypeError(
            f"`{env_id}` has no keyword `{unknown[0]}`; it has {', '.join(sorted(known))}"
        )
    if given.get(window, side) != side:
        raise ValueError(
            f"{window} must be {side}; for another window, change the `observe` line of the game"
        )
    steps = int(given.get("num_inner_steps", entry.steps))
    params = {ours: given[theirs] for theirs, ours in entry.kwargs.items() if theirs in given}
    arguments: dict[str, Any] = {"params": {"length": steps, **params}}
    if given.get("num_agents") is not None:
        arguments["num_agents"] = given["num_agents"]
    if given.get("map_ASCII") is not None:
        arguments["map"] = _our_map(given["map_ASCII"], entry.letters)
    mode = Mode(
        **{
            "shared_rewards": entry.shared_rewards,
            **{name: given[name] for name in modes & set(given)},
        }
    )
    return SocialJaxGame(
        entry,
        mode,
        steps,
        int(given.get("num_outer_steps", 1)),
        bool(given.get("cnn", True)),
        **arguments,
    )


def _our_map(rows: Sequence[str], letters: dict[str, str]) -> tuple[str, ...]:
    """Returns a map of the suite in our glyphs; short rows end in blanks, as there."""
    wrong = sorted(set("".join(rows)) - set(letters))
    if wrong:
        raise ValueError(
            f"map_ASCII can't have the letter `{wrong[0]}`; its letters are {' '.join(map(repr, letters))}"
        )
    width = max(map(len, rows), default=0)
    return tuple(
        "".join(letters[letter] for letter in row) + letters.get(" ", "") * (width - len(row))
        for row in rows
    )


COMMON = ("num_agents", "num_inner_steps", "num_outer_steps", "cnn", "jit")
registered_envs = tuple(entries())
