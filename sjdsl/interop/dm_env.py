"""dm_env adapter: a compiled game with the interface of a Melting Pot substrate."""

from collections.abc import Mapping, Sequence
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
OUTSIDE = 0  # in an observation: the look of what is off the map
TILE = 8  # pixels of a cell's side, as in Melting Pot


class Substrate(Copied, dm_env.Environment):
    """One environment of a game: actions, rewards and observations are lists, one entry a player.

    Observations: `RGB`, the player's window, `[rows * 8, cols * 8, 3]` uint8; of a substrate of Melting Pot, what else a player observes
    there, such as `READY_TO_SHOOT`, `INVENTORY` or `STAMINA` (docs/meltingpot.md lists which are left out); of another game with actions
    of its own, `READY_TO_SHOOT`, 1 if all of them are allowed; `COLLECTIVE_REWARD`, the sum of the step's rewards; `WORLD.RGB`, the whole
    board. Rewards are raw. An episode's last step has discount 1 where it is cut off, 0 where the rules end it. A step after it, or before
    `reset`, begins an episode, as dm_env has it.
    """

    KEPT = ("_key", "_state", "_events")

    def __init__(
        self, game: str, seed: int | None = None, tile: int = TILE, **arguments: Any
    ) -> None:
        """Makes the environment.

        Args:
          game: of `sjdsl.make`, or the name of a substrate of Melting Pot, such as `territory__rooms`.
          arguments: of `sjdsl.make`; a variant is added to that of the substrate.
          seed: the seed of all episodes; by default a new one each time.
          tile: the side of a cell in pixels.
        Raises:
          ValueError: a substrate that is not available yet, or a negative seed. TypeError: the seed isn't a whole number.
        """
        self.env = _make(game, arguments)
        self._key = seeded_key(seed)
        entry = _entry(game, arguments)
        self._rules: Mapping[str, Any] | None = None if entry is None else entry.observations
        self._look = replace(make_look(self.env.game), tile=tile)
        self._sees = jax.jit(self.env.module.observe)
        self._own_actions = [
            i for i, name in enumerate(self.env.action_names) if name not in BUILT_IN
        ]
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
        nothing = np.zeros(self.env.num_agents)
        return dm_env.TimeStep(dm_env.StepType.FIRST, list(nothing), 0.0, self._observe(nothing))

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
        made = dm_env.TimeStep(kind, list(rewards), discount, self._observe(rewards))
        if bool(done):
            self._state = None
        return made

    def events(self) -> list[tuple[str, Any]]:
        """Returns the events of the last step: names, each with the player's number (None for an event without one) and the count."""
        return list(self._events)

    def observation_spec(self) -> list[Mapping[str, specs.Array]]:
        """Returns the specs of each player's observation."""
        rows, cols = self.env.observation_shape[2:]
        tile = self._look.tile
        spec: dict[str, specs.Array] = {
            "RGB": specs.Array((rows * tile, cols * tile, 3), np.uint8, "RGB")
        }
        shapes = jax.eval_shape(self.env.reset, self._key)[1]
        nothing = jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), shapes)
        for name, values in self._other_observations(nothing).items():
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
        snapshot = take_snapshot(self.env, self._state, rewards)
        board = draw_board(self._look, snapshot)
        windows = self._windows(board, snapshot)
        others = self._other_observations(self._state)
        collective = np.array(rewards.sum())
        observations = []
        for player, window in enumerate(windows):
            own = {name: np.asarray(values[player]) for name, values in others.items()}
            observations.append(
                {"RGB": window, **own, "COLLECTIVE_REWARD": collective, "WORLD.RGB": board}
            )
        return observations

    def _other_observations(self, state: Any) -> dict[str, np.ndarray]:
        """Returns the players' other observations by name, `[N, …]` each."""
        if self._rules is not None:
            return {name: observe(self.env, state, rule) for name, rule in self._rules.items()}
        if not self._own_actions:
            return {}
        ready = np.all(np.asarray(self.env.allowed_actions(state))[:, self._own_actions], axis=1)
        return {"READY_TO_SHOOT": ready.astype(np.float64)}

    def _windows(self, board: np.ndarray, snapshot: Snapshot) -> np.ndarray:
        """Returns the window of each player on the board, black beyond its own window."""
        game = self.env.game
        windows = draw_windows(board, snapshot, game.window, self._look.tile)
        if not game.window.views:
            return windows
        content = np.asarray(self._sees(self._state, self.env.params))[:, 0]
        return where_seen(content != OUTSIDE, windows)


@dataclass(frozen=True)
class Config:
    """What is known about a game before it is built, by Melting Pot's names."""

    default_player_roles: tuple[str, ...]
    valid_roles: frozenset[str]
    action_names: tuple[str, ...]
    individual_observation_names: tuple[str, ...]
    global_observation_names: tuple[str, ...]


def get_config(game: str, **arguments: Any) -> Config:
    """Returns the configuration of a game or a substrate; every player has the role `default` unless Melting Pot gives another."""
    made = Substrate(game, **arguments)
    names = tuple(name for name in made.observation_spec()[0] if name != "WORLD.RGB")
    roles = _roles(game, made.env.num_agents)
    return Config(roles, frozenset(roles), made.action_names, names, ("WORLD.RGB",))


def build(
    game: str,
    roles: str | Sequence[str],
    seed: int | None = None,
    tile: int = TILE,
    **arguments: Any,
) -> Substrate:
    """Returns the game or substrate with one player for each role.

    Raises:
      ValueError: the game lacks a role, the roles are not those of its players in order, or it doesn't allow that number of players.
    """
    roles = several(roles)
    number = _make(game, arguments).num_agents
    usual = _roles(game, number)
    unknown = sorted(set(roles) - set(usual))
    if unknown and set(usual) == {ROLE}:
        raise ValueError(f"there is no role `{unknown[0]}`; every player has the role `{ROLE}`")
    if unknown:
        raise ValueError(
            f"there is no role `{unknown[0]}`; the roles are {', '.join(dict.fromkeys(usual))}"
        )
    if len(set(usual)) > 1 and tuple(roles) != usual:
        raise ValueError(f"`{game}` has the roles {', '.join(usual)}; give them in this order")
    if len(roles) != number:  # refused by games with a fixed number of agents
        arguments["num_agents"] = len(roles)
    return Substrate(game, seed, tile, **arguments)


def _make(game: str, arguments: Mapping[str, Any]) -> Environment:
    """Returns the environment of a substrate by its name there, or of any game.

    `clean_up` names both: it means the substrate, or, with the argument `variant` (None: the plain game), the game.
    Raises ValueError for a substrate that isn't available yet.
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
    """Returns the named substrate; None if the name is a game's."""
    entry = substrates().get(game)
    return (
        None
        if entry is None or (game in bundled() and ("variant" in arguments or not entry.game))
        else entry
    )


def _roles(game: str, number: int) -> tuple[str, ...]:
    """Returns the roles of the players: Melting Pot's if it names them and the number is that of the substrate."""
    entry = substrates().get(game)
    named = entry.roles if entry is not None else ()
    return named if len(named) == number else (ROLE,) * number


def _events(counts: Mapping[str, Any]) -> Any:
    for name, count in counts.items():
        values = np.asarray(count)
        for player, times in enumerate(values if values.ndim else [values]):
            if times:
                yield name, {"player": player if values.ndim else None, "times": int(times)}
