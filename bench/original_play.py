"""Plays Melting Pot itself with scripted players, on maps of one's own. Needs dmlab2d; bench/meltingpot_original.py says how to install it."""

import sys
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

Action = Mapping[str, int]
WAIT: Action = {}
FORWARD, BACK = {"move": 1}, {"move": 3}
TURN = {"turn": 1}
NORTH, EAST, SOUTH, WEST = range(4)
TILE = 8  # pixels


def find_melting_pot(source: str) -> None:
    """Makes `meltingpot` importable from its unpacked source archive; its own `__init__` would load the bots, and with them TensorFlow."""
    package = types.ModuleType("meltingpot")
    package.__path__ = [f"{source}/meltingpot"]
    sys.modules["meltingpot"] = package


class Play:
    """One episode of a substrate. Steps count from 1; columns come before rows in places, as there."""

    def __init__(
        self,
        name: str,
        rows: Sequence[str] = (),
        roles: Sequence[str] = (),
        legend: Mapping[str, Any] | None = None,
        change: Callable[[dict[str, Any]], None] | None = None,
        places: bool = True,
    ) -> None:
        """Begins an episode.

        Args:
          rows: a map instead of its own.
          roles: of the players; those of its own by default.
          legend: what letters of the map mean beside its own.
          change: is given the settings before they are used.
          places: whether `place` and `heading` can be asked.
        """
        from meltingpot import substrate
        from meltingpot.configs import substrates

        config = substrates.get_config(name)
        build = config.lab2d_settings_builder
        players = list(roles or config.default_player_roles)

        def settings(roles: Sequence[str], config: Any) -> dict[str, Any]:
            made = build(roles=roles, config=config)
            world = made["simulation"]
            if rows:
                world["map"] = "\n" + "\n".join(rows) + "\n"
            if legend:
                world["charPrefabMap"] = {**dict(world["charPrefabMap"]), **legend}
            for thing in world.get("gameObjects", ()):
                parts = {part["component"] for part in thing["components"]}
                if "Avatar" in parts and "LocationObserver" not in parts:
                    told = {"objectIsAvatar": True, "alsoReportOrientation": True}
                    thing["components"].append({"component": "LocationObserver", "kwargs": told})
            if change:
                change(made)
            return made

        with config.unlocked():
            config.lab2d_settings_builder = settings
            config.individual_observation_names = [*config.individual_observation_names, *(("POSITION", "ORIENTATION") if places else ())]
        self.env = substrate.build_from_config(config, roles=players)
        self.players, self.now = len(players), 0
        self._numbers = {frozenset((k, v) for k, v in dict(a).items() if v): i for i, a in enumerate(config.action_set)}
        self.seen = self.env.reset()

    def step(self, *actions: Action) -> "Play":
        """Plays one step; players without an action wait."""
        chosen = [*actions, *[WAIT] * (self.players - len(actions))]
        self.seen = self.env.step([self._numbers[frozenset(action.items())] for action in chosen])
        self.now += 1
        return self

    def rest(self, steps: int) -> "Play":
        """Lets everybody wait."""
        for _ in range(steps):
            self.step()
        return self

    def face(self, *headings: int) -> "Play":
        """Turns the players."""
        while any(self.heading(i) != wanted for i, wanted in enumerate(headings)):
            self.step(*[WAIT if self.heading(i) == wanted else TURN for i, wanted in enumerate(headings)])
        return self

    def told(self, name: str, player: int = 0) -> Any:
        """Returns an observation of a player."""
        return np.asarray(self.seen.observation[player][name]).tolist()

    def place(self, player: int) -> tuple[int, int]:
        """Returns column and row of a player; where it was last, if it is away."""
        col, row = self.told("POSITION", player)
        return int(col), int(row)

    def heading(self, player: int) -> int:
        """Returns 0 north, 1 east, 2 south, 3 west."""
        return int(self.told("ORIENTATION", player))

    def reward(self, player: int) -> float:
        """Returns the reward of the last step."""
        return float(np.asarray(self.seen.reward[player]))

    def events(self) -> list[str]:
        """Returns the names of what happened in the last step."""
        return [event[0] for event in self.env.events()]

    def world(self) -> bytes:
        """Returns the pixels of the whole map."""
        return np.asarray(self.seen.observation[0]["WORLD.RGB"]).tobytes()

    def cell(self, col: int, row: int) -> bytes:
        """Returns the pixels of a cell of the whole map."""
        world = np.asarray(self.seen.observation[0]["WORLD.RGB"])
        return world[TILE * row : TILE * (row + 1), TILE * col : TILE * (col + 1)].tobytes()

    def steps_until(self, happened: Callable[["Play"], bool], *actions: Action, most: int = 1000) -> int:
        """Returns after how many steps of these actions something has happened. Raises AssertionError if it has not in `most` steps."""
        for step in range(1, most + 1):
            if happened(self.step(*actions)):
                return step
        raise AssertionError(f"not in {most} steps")


def pair(name: str, rows: Sequence[str], **facts: Any) -> Play:
    """Returns two players who face each other, the first one west of the second: placing is by chance, and is tried again."""
    while True:
        play = Play(name, rows, roles=facts.pop("roles", ()) or ["default"] * 2, **facts)
        if play.place(0)[0] < play.place(1)[0]:
            return play.face(EAST, WEST)
        play.env.close()
