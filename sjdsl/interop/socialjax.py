"""SocialJax adapter: compiled games under the released suite's names.

With its calls, scales and orders.
"""

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

# Our number of each of the suite's moves. In some of its games the compass is turned round: `left`
# increases the column, `up` the row.
ACTIONS = {"turned round": (0, 1, 3, 2, 5, 4), "as ours": (0, 1, 2, 3, 4, 5)}
COMMON = ("num_agents", "num_inner_steps", "num_outer_steps", "cnn", "jit")  # keywords of all games
VARIANT = "socialjax"


@struct.dataclass
class State:
    """The state of the game, and the suite's counters."""

    game: Any
    inner_t: Array  # () int32: steps in this episode
    outer_t: Array  # () int32: episodes so far
    # Columns of the board, the width of its border, and whether the compass is turned round.
    frame: tuple[int, int, bool] = struct.field(pytree_node=False)

    @property
    def agent_locs(self) -> Array:
        """The places of the agents, `[N, 3]` int32: row, column, heading.

        Headings are numbered as in the suite: clockwise on its screen, from 0 for its `up`.
        """
        cols, border, is_turned = self.frame
        row, col = jnp.divmod(self.game.position.astype(jnp.int32), cols)
        heading = self.game.heading.astype(jnp.int32)
        if is_turned:
            heading = (2 - heading) % 4
        return jnp.stack([row - border, col - border, heading], axis=-1)


class SocialJaxGame(Copied):
    """One environment of a game, as in the suite.

    Integer agents, `[N, rows, cols, channels]` float32 observations, rewards `[N]`, dones by "0",
    "1", … and "__all__".

    Attributes:
      agents: 0, 1, …; num_agents; env: the `sjdsl.Environment`; name; observation_spaces,
        action_spaces: empty, like those of the suite's environments, which its `CTRolloutManager`
        reads.
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
        self.num_inner_steps = num_inner_steps
        self.num_outer_steps = num_outer_steps
        self.observation_spaces: dict[str, Any] = {}
        self.action_spaces: dict[str, Any] = {}
        self._info = entry.info
        self._flat = not cnn
        _, cols = self.env.module.FRAME
        self._frame = (cols, self.env.module.PAD, entry.compass == "turned round")
        depth, self._channels = make_channels(self.env, entry)
        self._rewards = make_rewards(mode, self.num_agents, entry.scaled, entry.shared)
        kind = "shaped" if mode.inequity_aversion or mode.svo or mode.interest else "alone"
        is_scaled = kind in entry.scaled and not mode.shared_rewards
        self._scale = self.num_agents if is_scaled else 1  # of a reward before shaping
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
        """The names of the suite's actions by their effects on our map, in the suite's order."""
        return tuple(self.env.action_names[number] for number in self._actions.tolist())

    def observation_space(self, agent: int | str | None = None) -> tuple[Any, tuple[int, ...]]:
        """Returns the space of an agent and its shape, a pair as in the suite.

        All agents have the same.
        """
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
        """Plays one step.

        After the last episode, returns the first state of the next, or `reset_state`.

        Args:
          actions: N numbers or arrays of shape `()` or `(1,)`, in the order of `agents`.
          timestep: the time step of the training, for a schedule of reward exchange.
        """
        observation, game, reward, episode_done, info = self.env.step(
            key, state.game, self._our_actions(actions)
        )
        state = self._next_state(state, game, episode_done)
        done = state.outer_t >= self.num_outer_steps
        state = replace(state, outer_t=jnp.where(done, 0, state.outer_t))
        if reset_state is not None:
            state = jax.tree.map(partial(jnp.where, done), reset_state, state)
            observation = self.env.observe(state.game)
        return (
            self._observation(observation),
            state,
            *self._results(reward, done, info, actions, timestep),
        )

    @partial(jax.jit, static_argnums=(0,))
    def step_env(
        self, key: Array, state: State, actions: Sequence[Array] | Array, timestep: Any = 0
    ) -> tuple[Array, State, Array, dict[str, Array], dict[str, Array]]:
        """As `step`, but keeps the last state of the last episode."""
        _, game, reward, episode_done, info = self.env.step(
            key, state.game, self._our_actions(actions)
        )
        state = self._next_state(state, game, episode_done)
        done = state.outer_t >= self.num_outer_steps
        game = jax.tree.map(partial(jnp.where, done), info["terminal_state"], game)
        return (
            self._observation(self.env.observe(game)),
            replace(state, game=game),
            *self._results(reward, done, info, actions, timestep),
        )

    def get_obs(self, state: State) -> Array:
        """Returns the observations of a state."""
        return self._observation(self.env.observe(state.game))

    def render(self, state: State) -> Any:
        """Returns the board as a picture, `[height, width, 3]` uint8."""
        import numpy as np

        from sjdsl.render.board import draw_board

        snapshot = take_snapshot(self.env, state.game, np.zeros(self.num_agents))
        return draw_board(make_look(self.env.game), snapshot)

    def _our_actions(self, actions: Sequence[Array] | Array) -> Array:
        """Returns the action numbers of our game.

        Numbers out of range have no effect, as in the suite.
        """
        numbers = self._stacked(actions)
        in_range = (numbers >= 0) & (numbers < self.env.num_actions)
        return jnp.where(in_range, self._actions[jnp.where(in_range, numbers, 0)], -1)

    def _stacked(self, actions: Sequence[Array] | Array) -> Array:
        """Returns the suite's action numbers as one array, `[N]`."""
        stacked = jnp.stack([jnp.reshape(action, ()) for action in actions])
        return checked_actions(stacked, self.num_agents)

    def _next_state(self, state: State, game: Any, episode_done: Array) -> State:
        """Returns the state with the game's next one, and the suite's counters one step on."""
        return State(
            game,
            jnp.where(episode_done, 0, state.inner_t + 1),
            state.outer_t + episode_done.astype(jnp.int32),
            self._frame,
        )

    def _observation(self, observation: Array) -> Array:
        """Returns the suite's channels of our observation."""
        channels = self._channels(observation)
        return channels.reshape(self.num_agents, -1) if self._flat else channels

    def _results(
        self, raw: Array, done: Array, info: dict[str, Any], actions: Any, timestep: Any
    ) -> tuple[Array, dict[str, Array], dict[str, Array]]:
        """Returns rewards, dones and infos in the suite's form. `raw`: the game's rewards."""
        rewards, infos = self._rewards(raw, timestep)
        infos["original_rewards"] = self._scale * raw
        infos["shaped_rewards"] = rewards
        for name, figure in self._info.items():
            infos[name] = self._figure(figure, info, actions)
        dones = {**{str(agent): done for agent in self.agents}, "__all__": done}
        return rewards, dones, infos

    def _figure(self, figure: Figure, info: dict[str, Any], actions: Any) -> Array:
        """Returns one number of the infos for each agent, `[N]` float32."""
        if figure.action is not None:
            number = self.action_names.index(figure.action)
            return (self._stacked(actions) == number).astype(jnp.float32)
        counts = {**info["metrics"], **info["events"]}
        value = jnp.asarray(counts[figure.of], jnp.float32)
        if figure.sum:
            value = value.sum()
        for factor in figure.times:
            value = value * self._factor(factor)
        return jnp.broadcast_to(value, (self.num_agents,))

    def _factor(self, factor: str | int) -> Any:
        """Returns a number, or the number of this name: `agents`, `steps` or a parameter."""
        match factor:
            case int():
                return factor
            case "agents":
                return self.num_agents
            case "steps":
                return self.num_inner_steps
        return getattr(self.env.params, factor)


def make(env_id: str, **kwargs: Any) -> SocialJaxGame:
    """Returns a game by the suite's id, with its keyword arguments.

    Args:
      env_id: one of `registered_envs`.
      kwargs: `num_agents`, `num_inner_steps` (1000; lb_foraging 100), `num_outer_steps` (1), `cnn`,
        `jit`, `obs_size` (11; lb_foraging's is `sight`, 8), `map_ASCII`, those that choose the
        reward (`socialjax_rewards.Mode`), and the game's own.
    Raises:
      ValueError: an unknown id or value. TypeError: an unknown keyword. Both messages list the
        known ones.
    """
    if env_id not in entries():
        raise ValueError(f"there is no id `{env_id}`; the ids are {', '.join(entries())}")
    entry = entries()[env_id]
    mode_names = {field.name for field in fields(Mode)}
    window, side = entry.window
    known = {*mode_names, *entry.kwargs, *COMMON, window}
    if entry.letters:
        known.add("map_ASCII")
    unknown = sorted(set(kwargs) - known)
    if unknown:
        raise TypeError(
            f"`{env_id}` has no keyword `{unknown[0]}`; it has {', '.join(sorted(known))}"
        )
    if kwargs.get(window, side) != side:
        raise ValueError(
            f"{window} must be {side}; for another window, change the `observe` line of the game"
        )
    steps = int(kwargs.get("num_inner_steps", entry.steps))
    params = {ours: kwargs[theirs] for theirs, ours in entry.kwargs.items() if theirs in kwargs}
    arguments: dict[str, Any] = {"params": {"length": steps, **params}}
    if kwargs.get("num_agents") is not None:
        arguments["num_agents"] = kwargs["num_agents"]
    if kwargs.get("map_ASCII") is not None:
        arguments["map"] = _our_map(kwargs["map_ASCII"], entry.letters)
    modes = {name: kwargs[name] for name in mode_names & set(kwargs)}
    return SocialJaxGame(
        entry,
        Mode(**{"shared_rewards": entry.shared_rewards, **modes}),
        steps,
        int(kwargs.get("num_outer_steps", 1)),
        bool(kwargs.get("cnn", True)),
        **arguments,
    )


def _our_map(rows: Sequence[str], letters: dict[str, str]) -> tuple[str, ...]:
    """Returns a map of the suite in our glyphs.

    As in the suite, short rows are filled with blanks.
    """
    unknown = sorted(set("".join(rows)) - set(letters))
    if unknown:
        raise ValueError(
            f"map_ASCII can't have the letter `{unknown[0]}`; "
            f"its letters are {' '.join(map(repr, letters))}"
        )
    width = max(map(len, rows), default=0)
    blank = letters.get(" ", "")
    return tuple(
        "".join(letters[letter] for letter in row) + blank * (width - len(row)) for row in rows
    )


registered_envs = tuple(entries())
