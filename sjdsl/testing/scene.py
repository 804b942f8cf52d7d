"""`Scene`: one state of a game on a stage, and the questions that a test can ask about it.

Both engines take each step.
"""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import jax
import numpy as np

from sjdsl.compiler.ir.queries import marking_phases
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import HEADINGS, Herd, World
from sjdsl.library.action_names import split_actions
from sjdsl.near_names import meant
from sjdsl.runtime.env import Environment
from sjdsl.testing.engines import (
    Compiled,
    Numbers,
    interpret_look,
    interpret_step,
    look_at,
    take_step,
)
from sjdsl.testing.paths import by_owner, find_field, owners_of, read_field
from sjdsl.testing.pictures import Row, compare_pictures, draw_cells, draw_picture, read_picture
from sjdsl.testing.signs import Signs
from sjdsl.testing.states import compiled_state
from sjdsl.testing.values import is_expected, merged

SHORT = 8  # a longer list is not shown in full in a message
_ATTRIBUTES: dict[str, Callable[[World | Herd], list[Any]]] = {
    "row": lambda herd: [None if place is None else place.row for place in herd.position],
    "col": lambda herd: [None if place is None else place.col for place in herd.position],
    "moved": lambda herd: list(herd.moved),
    "away": lambda herd: [away is not None for away in herd.away],
    "ticks": lambda herd: [away.ticks if away else 0 for away in herd.away],
}


class Setting(Protocol):
    """The attributes of a `Stage` that a scene on it uses."""

    @property
    def env(self) -> Environment: ...
    @property
    def signs(self) -> Signs: ...
    @property
    def compiled(self) -> Compiled: ...
    @property
    def board(self) -> Board: ...
    @property
    def interpreted(self) -> bool: ...
    def numbers(self, params: Mapping[str, Any]) -> Numbers: ...


class Scene:
    """A state of a game.

    Both engines take every step, and must agree in every field, reward, event, metric and
    observation.

    On a stage that is `interpreted`, only the interpreter takes the steps.

    Attributes:
      reward: `[N]` of the last step; events, metrics: by name, of the last step, as in `info`;
        terminated, truncated: bool.
      state, params: of the compiled game (no state on a stage that is `interpreted`); world: of the
        interpreter.
    """

    def __init__(self, stage: Setting, world: World, params: Mapping[str, Any], seed: int):
        self.stage = stage
        self.env = stage.env
        self.world = world
        self.seed = seed
        self._past: list[str] = []  # the actions of each step so far
        self._seen: tuple[np.ndarray, np.ndarray] | None = None
        self._set_params(params)
        self.state: Any = None
        if not stage.interpreted:
            self.state = compiled_state(stage.env, stage.compiled.blank, world)
        self.reward: list[float] = []
        self.events: dict[str, Any] = {}
        self.metrics: dict[str, float] = {}
        self.terminated = False
        self.truncated = False

    @property
    def observation(self) -> np.ndarray:
        """The observations of the agents: `[N, rows, cols, planes]` uint8 tokens."""
        observation, _ = self._look()
        return observation

    @property
    def allowed(self) -> np.ndarray:
        """Which actions each agent may take: `[N, actions]` bool."""
        _, allowed = self._look()
        return allowed

    def _look(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns the observation and the allowed actions, computed once for a state."""
        if self._seen is None and self.stage.interpreted:
            self._seen = interpret_look(self.env, self.world)
        if self._seen is None:
            self._seen = look_at(self.stage.compiled, self.state, self.world, self.params)
        return self._seen

    def change(self, **params: Any) -> "Scene":
        """Sets run-time numbers for the steps that follow."""
        self._set_params(merged(self._changed_params, params))
        return self

    def _set_params(self, changed: Mapping[str, Any]) -> None:
        self._seen = None
        self._changed_params = dict(changed)
        self._numbers = self.stage.numbers(changed)
        self.params = self._numbers.compiled

    def step(self, actions: str = "", times: int = 1) -> "Scene":
        """Takes a step, or several with the same actions.

        `actions` has the names of the actions of agent 0, 1, …, separated by commas; the other
        agents stay. Raises ValueError for an unknown action, AssertionError if the two engines
        differ.
        """
        __tracebackhide__ = True
        chosen = self._read_actions(actions)
        for _ in range(times):
            if self.stage.interpreted:
                stepped = interpret_step(self.env, self.world, chosen, self._numbers, self.seed)
            else:
                stepped = take_step(
                    self.stage.compiled, self.state, self.world, chosen, self._numbers, self.seed
                )
            self.state = stepped.state
            self.world = stepped.world
            self._seen = stepped.seen
            self.reward = stepped.reward
            self.events = stepped.events
            self.metrics = stepped.metrics
            self.terminated = stepped.terminated
            self.truncated = stepped.truncated
            self.seed += 1
            self._past.append(actions or "all stay")
        return self

    def _read_actions(self, actions: str) -> list[int]:
        """Returns the action of each agent; those that have none in the text stay."""
        known = self.env.action_names
        agents = self.env.num_agents
        names = list(split_actions(actions)) if actions.strip() else []
        if len(names) > agents:
            raise ValueError(f"{len(names)} actions for {agents} agents: {actions}")
        for name in names:
            if name not in known:
                raise ValueError(f"`{name}` isn't an action of this game{meant(name, known)}")
        names += ["stay"] * (agents - len(names))
        return [known.index(name) for name in names]

    def shows(self, *picture: str, under: Mapping[int, str] | None = None) -> "Scene":
        """Asserts what the map looks like now.

        Numbers of agents are compared in rows of the picture that have them. `under` has the signs
        of the cells under agents.
        """
        __tracebackhide__ = True
        expected = read_picture(picture, self.stage.signs)
        difference = compare_pictures(expected, self._rows())
        if difference is not None:
            raise AssertionError(f"{self._when()}the map differs\n{difference}")
        for agent, sign in (under or {}).items():
            if self.under(agent) != sign:
                raise AssertionError(
                    f"{self._when()}agent {agent} stands on `{self.under(agent)}`, not on `{sign}`"
                )
        return self

    def has(self, expected: Mapping[str, Any]) -> "Scene":
        """Asserts values by the names that `value` reads.

        An expected value is a list over agents or cells, a mapping of some of them, or one value
        for all.
        """
        __tracebackhide__ = True
        lines: list[str] = []
        for name, value in expected.items():
            lines += self._differences(name, value)
        if lines:
            text = "\n".join(f"  {line}" for line in [*lines, "the map:", *self._rows()])
            raise AssertionError(f"{self._when()}some values differ\n{text}")
        return self

    def value(self, name: str) -> Any:
        """Returns the value of a name.

        * `agent.FIELD`, `KIND.FIELD`: a list over agents or cells; `FIELD`: of the world;
          `…[word]`: one entry of a `by` field.
        * `agent.row`, `agent.col`, `agent.heading`, `agent.moved`, `agent.away` (a condition),
          `agent.ticks` (until it returns). Names of movers are like those of agents: `deer.row`.
        * `allowed ACTION`: whether each agent may take it; `marks PHASE`: (row, column) of the
          marked cells; `steps`.
        * Of the last step: `reward`, `event NAME`, `metric NAME`, `terminated`, `truncated`.

        Raises:
          ValueError: there is no such name.
        """
        value, _ = self._read(name)
        return value

    def under(self, agent: int) -> str:
        """Returns the sign of the cell that an agent stands on."""
        row, col = self._place(agent)
        return draw_cells(self.stage.signs, self.stage.board, self.world)[row][col]

    def places(self) -> list[tuple[int, int] | None]:
        """Returns the (row, column) of each agent, None for one that is away."""
        return [None if place is None else (place.row, place.col) for place in self.world.position]

    def headings(self) -> list[str]:
        """Returns the heading of each agent as a word."""
        return [HEADINGS[heading] for heading in self.world.heading]

    def picture(self) -> list[str]:
        """Returns the current map, with the numbers of the agents of each row beside it."""
        return [str(row) for row in self._rows()]

    def seen(self, agent: int, plane: str, ahead: int = 0, right: int = 0) -> Any:
        """Returns what an agent sees in a plane so many cells ahead and to its right.

        It is a label, a number, or labels joined by `+`.
        """
        window = self.env.game.window
        names = [token_plane.name for token_plane in self.env.token_planes]
        if plane not in names:
            raise ValueError(f"there is no plane `{plane}`{meant(plane, names)}")
        self._place(agent)
        if not (-window.behind <= ahead <= window.ahead and -window.left <= right <= window.right):
            raise ValueError(f"{ahead} ahead, {right} to the right is outside the window")
        index = names.index(plane)
        token = int(self.observation[agent, index, window.ahead - ahead, window.left + right])
        labels = self.env.token_planes[index].labels
        match self.env.token_planes[index].encoding:
            case "bits":
                return "+".join(label for bit, label in enumerate(labels) if token >> bit & 1)
            case "word":
                return labels[token]
            case _:
                return token

    def compare_start(self, seed: int) -> None:
        """Asserts that the compiled reset of a seed gives this scene."""
        _, self.state = self.env.reset(jax.random.key(seed), self.params)
        self._seen = look_at(self.stage.compiled, self.state, self.world, self.params)

    def _rows(self) -> list[Row]:
        return draw_picture(self.stage.signs, self.stage.board, self.world)

    def _place(self, agent: int) -> tuple[int, int]:
        """Returns the row and column of an agent. Raises ValueError if it is away."""
        place = self.places()[agent]
        if place is None:
            raise ValueError(f"agent {agent} is away")
        return place

    def _when(self) -> str:
        return f"after {'; '.join(self._past)}: " if self._past else ""

    def _differences(self, name: str, expected: Any) -> list[str]:
        """Returns lines about where the value of a name isn't the expected one."""
        actual, owners = self._read(name)
        if owners is None:
            return [] if is_expected(actual, expected) else [f"{name} is {actual}, not {expected}"]
        values = dict(zip(owners, actual, strict=True))
        differing = [
            owner
            for owner, value in by_owner(name, expected, owners).items()
            if not is_expected(values[owner], value)
        ]
        if differing and len(actual) <= SHORT:
            return [f"{name} is {actual}, not {expected}"]
        return [f"{name} of {owner} is {values[owner]}" for owner in differing[:5]]

    def _read(self, name: str) -> tuple[Any, list[Any] | None]:
        """Returns the value of a name; if it is a list, also the owners of its entries."""
        agents = list(range(self.env.num_agents))
        first, _, rest = name.strip().partition(" ")
        readers: dict[str, Callable[[str], Any]] = {
            "event": self._event,
            "metric": self._metric,
            "allowed": self._allowed,
            "marks": self._marks,
        }
        if rest and first in readers:
            value = readers[first](rest)
            return value, agents if isinstance(value, list) else None
        match name:
            case "steps":
                return self.world.step, None
            case "terminated":
                return self.terminated, None
            case "truncated":
                return self.truncated, None
            case "reward":
                return self._of_last_step(self.reward), agents
            case "agent.heading":
                return self.headings(), agents
        entity_type, _, attribute = name.partition(".")
        if attribute in _ATTRIBUTES and entity_type in {"agent", *self.world.movers}:
            values = _ATTRIBUTES[attribute](self.world.movers.get(entity_type, self.world))
            return values, list(range(len(values)))
        path = find_field(self.env.game, name)
        return read_field(path, self.world), owners_of(path, self.stage.board)

    def _of_last_step(self, value: Any) -> Any:
        """Returns a value of the last step. Raises ValueError if there was none."""
        if not self.reward:
            raise ValueError("no step has been taken, so there are no rewards, events or metrics")
        return value

    def _event(self, name: str) -> Any:
        return self._named(name, self._of_last_step(self.events), "event")

    def _metric(self, name: str) -> Any:
        return self._named(name, self._of_last_step(self.metrics), "metric")

    def _named(self, name: str, values: Mapping[str, Any], label: str) -> Any:
        """Returns the value of an event or a metric. Raises ValueError for an unknown name."""
        if name not in values:
            raise ValueError(f"the game has no {label} `{name}`{meant(name, values)}")
        return values[name]

    def _allowed(self, action: str) -> list[bool]:
        """Returns whether each agent may take an action."""
        number = self._read_actions(action)[0]
        return list(self.allowed[:, number].tolist())

    def _marks(self, label: str) -> set[tuple[int, int]]:
        """Returns the row and column of the cells that a phase has marked."""
        names = {phase.label: phase.name for phase in marking_phases(self.env.game)}
        if label not in names:
            raise ValueError(f"no phase `{label}` marks cells{meant(label, names)}")
        return {(row, col) for name, row, col in self.world.marks if name == names[label]}
