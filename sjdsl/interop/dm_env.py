"""dm_env adapter: a compiled game with the interface of a Melting Pot substrate."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import numbers_of_actions, seeded_key
from sjdsl.interop.copies import Copied
from sjdsl.interop.melting_pot_observations import observe
from sjdsl.library.factory import make
from sjdsl.library.games_folder import bundled
from sjdsl.library.substrates import Substrate as Entry
from sjdsl.library.substrates import substrates
from sjdsl.render import take_snapshot
from sjdsl.render.board import draw_board, draw_windows, where_seen
from sjdsl.render.look import make_look
from sjdsl.render.moment import Snapshot
from sjdsl.runtime.actions import BUILT_IN
from sjdsl.runtime.env import Environment
from sjdsl.several import several

with needs("dm_env"):
    import dm_env
    from dm_env import specs

Observation = dict[str, np.ndarray]
ROLE = "default"
OUTSIDE = 0  # in an observation: the token of cells that are off the map
TILE = 8  # pixels of a cell's side, as in Melting Pot


class Substrate(Copied, dm_env.Environment):
    """One environment of a game.

    Actions, rewards and observations are lists, with an entry for each player.

    Observations: `RGB`, the player's window, `[rows * 8, cols * 8, 3]` uint8; in a substrate of
    Melting Pot, the other observations of a player there, such as `READY_TO_SHOOT`, `INVENTORY` or
    `STAMINA` (docs/meltingpot.md lists which are left out); in another game with actions of its
    own, `READY_TO_SHOOT`, 1 if all of them are allowed; `COLLECTIVE_REWARD`, the sum of the step's
    rewards; `WORLD.RGB`, the whole board. Rewards are raw. The last step of an episode has discount
    1 where it is cut off, 0 where the rules end it. As dm_env requires, a step after it, or before
    `reset`, begins an episode.
    """

    KEPT = ("_key", "_state", "_events")

    def __init__(
        self, game: str, seed: int | None = None, tile: int = TILE, **arguments: Any
    ) -> None:
        """Makes the environment.

        Args:
          game: of `sjdsl.make`, or the name of a substrate of Melting Pot, such as
            `territory__rooms`.
          arguments: of `sjdsl.make`; a variant is added to that of the substrate.
          seed: the seed of all episodes; by default a new one each time.
          tile: the side of a cell in pixels.
        Raises:
          ValueError: a substrate that is not available yet, or a negative seed. TypeError: the seed
            isn't a whole number.
        """
        self.env = _make(game, arguments)
        self._key = seeded_key(seed)
        entry = _entry(game, arguments)
        self._rules: Mapping[str, Any] | None = None if entry is None else entry.observations
        self._look = replace(make_look(self.env.game), tile=tile)
        self._compute_observation = jax.jit(self.env.module.observe)
        names = self.env.action_names
        self._game_actions = [i for i, name in enumerate(names) if name not in BUILT_IN]
        self._state: Any = None
        self._events: list[tuple[str, Any]] = []

    @property
    def action_names(self) -> tuple[str, ...]:
        """The names of the actions of `action_spec`."""
        return self.env.action_names

    def reset(self) -> dm_env.TimeStep:
        """Begins an episode."""
        self._key, key = jax.random.split(self._key)
        _, self._state = self.env.reset(key)
        self._events = []
        rewards = np.zeros(self.env.num_agents)
        return dm_env.TimeStep(dm_env.StepType.FIRST, list(rewards), 0.0, self._observe(rewards))

    def step(self, action: Sequence[int]) -> dm_env.TimeStep:
        """Plays one step; `action` has one number for each player."""
        if self._state is None:
            return self.reset()
        if len(action) != self.env.num_agents:
            raise ValueError(
                f"expected {self.env.num_agents} actions, one for each player, got {len(action)}"
            )
        chosen = numbers_of_actions(
            action, self.env.num_actions, lambda player: f" of player {player}"
        )
        self._key, key = jax.random.split(self._key)
        _, self._state, reward, done, info = self.env.step_env(key, self._state, chosen)
        rewards = np.asarray(reward, np.float64)
        self._events = list(_events(info["events"]))
        kind = dm_env.StepType.LAST if bool(done) else dm_env.StepType.MID
        discount = 0.0 if bool(info["terminated"]) else 1.0
        timestep = dm_env.TimeStep(kind, list(rewards), discount, self._observe(rewards))
        if bool(done):
            self._state = None
        return timestep

    def events(self) -> list[tuple[str, Any]]:
        """Returns the events of the last step.

        Names, each with the number of the player (None for an event without one) and the count.
        """
        return list(self._events)

    def observation_spec(self) -> list[Mapping[str, specs.Array]]:
        """Returns the specs of each player's observation."""
        rows, cols = self.env.observation_shape[2:]
        tile = self._look.tile
        spec: dict[str, specs.Array] = {
            "RGB": specs.Array((rows * tile, cols * tile, 3), np.uint8, "RGB")
        }
        shapes = jax.eval_shape(self.env.reset, self._key)[1]
        zeros = jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), shapes)
        for name, values in self._other_observations(zeros).items():
            spec[name] = specs.Array(values.shape[1:], values.dtype, name)
        spec["COLLECTIVE_REWARD"] = specs.Array((), np.float64, "COLLECTIVE_REWARD")
        board = (self._look.height * tile, self._look.width * tile, 3)
        spec["WORLD.RGB"] = specs.Array(board, np.uint8, "WORLD.RGB")
        return [dict(spec) for _ in range(self.env.num_agents)]

    def action_spec(self) -> list[specs.DiscreteArray]:
        """Returns the spec of each player's action."""
        return [
            specs.DiscreteArray(self.env.num_actions, np.int64, "action")
            for _ in range(self.env.num_agents)
        ]

    def reward_spec(self) -> list[specs.Array]:
        """Returns the spec of each player's reward."""
        return [specs.Array((), np.float64, "REWARD") for _ in range(self.env.num_agents)]

    def discount_spec(self) -> specs.BoundedArray:
        """Returns the spec of the discount."""
        return specs.BoundedArray((), np.float64, 0.0, 1.0, "discount")

    def close(self) -> None:
        """Does nothing: there is nothing to release."""

    def _observe(self, rewards: np.ndarray) -> list[Observation]:
        """Returns the observation of each player in the current state."""
        snapshot = take_snapshot(self.env, self._state, rewards)
        board = draw_board(self._look, snapshot)
        windows = self._windows(board, snapshot)
        others = self._other_observations(self._state)
        collective = np.array(rewards.sum())
        observations = []
        for player, window in enumerate(windows):
            observation = {"RGB": window}
            for name, values in others.items():
                observation[name] = np.asarray(values[player])
            observation["COLLECTIVE_REWARD"] = collective
            observation["WORLD.RGB"] = board
            observations.append(observation)
        return observations

    def _other_observations(self, state: Any) -> dict[str, np.ndarray]:
        """Returns the players' other observations by name, `[N, …]` each."""
        if self._rules is not None:
            return {name: observe(self.env, state, rule) for name, rule in self._rules.items()}
        if not self._game_actions:
            return {}
        allowed = np.asarray(self.env.allowed_actions(state))
        is_ready = np.asarray(allowed[:, self._game_actions].all(axis=1), np.float64)
        return {"READY_TO_SHOOT": is_ready}

    def _windows(self, board: np.ndarray, snapshot: Snapshot) -> np.ndarray:
        """Returns the window of each player on the board, black where the player sees nothing."""
        game = self.env.game
        windows = draw_windows(board, snapshot, game.window, self._look.tile)
        if not game.window.views:
            return windows
        content = np.asarray(self._compute_observation(self._state, self.env.params))[:, 0]
        return where_seen(content != OUTSIDE, windows)


@dataclass(frozen=True)
class Config:
    """The properties of a game that don't need its state, under Melting Pot's names."""

    default_player_roles: tuple[str, ...]
    valid_roles: frozenset[str]
    action_names: tuple[str, ...]
    individual_observation_names: tuple[str, ...]
    global_observation_names: tuple[str, ...]


def get_config(game: str, **arguments: Any) -> Config:
    """Returns the configuration of a game or a substrate.

    Every player has the role `default` unless Melting Pot gives it another.
    """
    substrate = Substrate(game, **arguments)
    names = tuple(name for name in substrate.observation_spec()[0] if name != "WORLD.RGB")
    roles = _roles(game, substrate.env.num_agents)
    return Config(roles, frozenset(roles), substrate.action_names, names, ("WORLD.RGB",))


def build(
    game: str,
    roles: str | Sequence[str],
    seed: int | None = None,
    tile: int = TILE,
    **arguments: Any,
) -> Substrate:
    """Returns the game or substrate with one player for each role.

    Raises:
      ValueError: the game lacks a role, the roles are not those of its players in order, or it
        doesn't allow that number of players.
    """
    roles = several(roles)
    number = _make(game, arguments).num_agents
    default = _roles(game, number)
    unknown = sorted(set(roles) - set(default))
    if unknown and set(default) == {ROLE}:
        raise ValueError(f"there is no role `{unknown[0]}`; every player has the role `{ROLE}`")
    if unknown:
        raise ValueError(
            f"there is no role `{unknown[0]}`; the roles are {', '.join(dict.fromkeys(default))}"
        )
    if len(set(default)) > 1 and roles != default:
        raise ValueError(f"`{game}` has the roles {', '.join(default)}; give them in this order")
    if len(roles) != number:  # a game with a fixed number of agents refuses another
        arguments["num_agents"] = len(roles)
    return Substrate(game, seed, tile, **arguments)


def _make(game: str, arguments: Mapping[str, Any]) -> Environment:
    """Returns the environment of a substrate by its name there, or of any game.

    `clean_up` is the name of both: it means the substrate, or, with the argument `variant` (None:
    the game without a variant), the game. Raises ValueError for a substrate that isn't available
    yet.
    """
    entry = _entry(game, arguments)
    if entry is None:
        return make(game, **arguments)
    if not entry.game:
        raise ValueError(
            f"the substrate `{game}` isn't available yet; docs/meltingpot.md lists those that are"
        )
    variant = "+".join(name for name in (entry.variant, arguments.get("variant")) if name)
    return make(entry.game, **{**arguments, "variant": variant or None})


def _entry(game: str, arguments: Mapping[str, Any]) -> Entry | None:
    """Returns the named substrate; None if the name is that of a game."""
    entry = substrates().get(game)
    if entry is None:
        return None
    is_game = game in bundled() and ("variant" in arguments or not entry.game)
    return None if is_game else entry


def _roles(game: str, number: int) -> tuple[str, ...]:
    """Returns the roles of the players: Melting Pot's if it names one for each, else `default`."""
    entry = substrates().get(game)
    if entry is not None and len(entry.roles) == number:
        return entry.roles
    return (ROLE,) * number


def _events(counts: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yields the events of a step that happened, as `Substrate.events` returns them."""
    for name, count in counts.items():
        values = np.asarray(count)
        if values.ndim == 0 and values:
            yield name, {"player": None, "times": int(values)}
        if values.ndim == 1:
            for player in np.nonzero(values)[0]:
                yield name, {"player": int(player), "times": int(values[player])}
