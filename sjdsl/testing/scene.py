"""`Scene`: one state of a game on a stage, stepped by both engines together, and the questions a test can ask of it."""

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
from sjdsl.testing.values import merged, same

_ATTRIBUTES: dict[str, Callable[[World | Herd], list[Any]]] = {
    "row": lambda herd: [None if place is None else place.row for place in herd.position],
    "col": lambda herd: [None if place is None else place.col for place in herd.position],
    "moved": lambda herd: list(herd.moved),
    "away": lambda herd: [away is not None for away in herd.away],
    "ticks": lambda herd: [away.ticks if away else 0 for away in herd.away],
}


class Setting(Protocol):
    """What a scene needs of the `Stage` that it is put on."""

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
    """A state of a game. Every step is taken twice and must come out alike in every field, reward, event, metric and observation.

    On a stage that is `interpreted` the interpreter takes it alone.

    Attributes:
      reward: `[N]` of the last step; events, metrics: by name, of the last step, as `info` has them; terminated, truncated: bool.
      state, params: of the compiled game (no state on a stage that is `interpreted`); world: of the interpreter.
    """

    def __init__(self, stage: Setting, world: World, params: Mapping[str, Any], seed: int):
        self.stage, self.env, self.world = stage, stage.env, world
        self.seed, self._past = seed, ""
        self._seen: tuple[np.ndarray, np.ndarray] | None = None
        self._set_params(params)
        self.state = (
            None if stage.interpreted else compiled_state(stage.env, stage.compiled.blank, world)
        )
        self.reward: list[float] = []
        self.events: dict[str, Any] = {}
        self.metrics: dict[str, float] = {}
        self.terminated = self.truncated = False

    @property
    def observation(self) -> np.ndarray:
        """What the agents see: `[N, rows, cols, planes]` uint8 tokens."""
        return self._looked()[0]

    @property
    def allowed(self) -> np.ndarray:
        """Which actions each agent may take: `[N, actions]` bool."""
        return self._looked()[1]

    def _looked(self) -> tuple[np.ndarray, np.ndarray]:
        if self._seen is None and self.stage.interpreted:
            self._seen = interpret_look(self.env, self.world)
        if self._seen is None:
            self._seen = look_at(self.stage.compiled, self.state, self.world, self.params)
        return self._seen

    def change(self, **params: Any) -> "Scene":
        """Sets run-time numbers for the steps that follow."""
        self._set_params(merged(self._changed, params))
        return self

    def _set_params(self, changed: Mapping[str, Any]) -> None:
        self._seen = None
        self._changed, self._numbers = dict(changed), self.stage.numbers(changed)
        self.params = self._numbers.compiled

    def step(self, actions: str = "", times: int = 1) -> "Scene":
        """Takes a step, or several with the same actions: the names of what agent 0, 1, … do, parted by commas; who is not named stays.

        Raises ValueError for an unknown action, AssertionError if the two engines differ.
        """
        __tracebackhide__ = True
        chosen = self._chosen(actions)
        for _ in range(times):
            if self.stage.interpreted:
                stepped = interpret_step(self.env, self.world, chosen, self._numbers, self.seed)
            else:
                stepped = take_step(
                    self.stage.compiled, self.state, self.world, chosen, self._numbers, self.seed
                )
            self.state, self.world, self._seen = stepped.state, stepped.world, stepped.seen
            self.reward, self.events, self.metrics = stepped.reward, stepped.events, stepped.metrics
            self.terminated, self.truncated = stepped.terminated, stepped.truncated
            self.seed += 1
            self._past += f"; {actions or 'all stay'}"
        return self

    def _chosen(self, actions: str) -> list[int]:
        names, agents = self.env.action_names, self.env.num_agents
        wanted = split_actions(actions) if actions.strip() else []
        if len(wanted) > agents:
            raise ValueError(f"{len(wanted)} actions for {agents} agents: {actions}")
        for name in wanted:
            if name not in names:
                raise ValueError(f"`{name}` isn't an action of this game{meant(name, names)}")
        return [names.index(name) for name in [*wanted, *["stay"] * agents][:agents]]

    def shows(self, *picture: str, under: Mapping[int, str] | None = None) -> "Scene":
        """Asserts what the map looks like now. Numbers of agents are compared in rows that tell them. `under`: signs agents stand on."""
        __tracebackhide__ = True
        wanted = read_picture(picture, self.stage.signs)
        difference = compare_pictures(wanted, self._rows())
        if difference is not None:
            raise AssertionError(f"{self._when()}the map differs\n{difference}")
        for agent, sign in (under or {}).items():
            if self.under(agent) != sign:
                raise AssertionError(
                    f"{self._when()}agent {agent} stands on `{self.under(agent)}`, not on `{sign}`"
                )
        return self

    def has(self, expected: Mapping[str, Any]) -> "Scene":
        """Asserts values: what `value` reads -> a list over agents or cells, a mapping of some of them, or one value for all."""
        __tracebackhide__ = True
        wrong = [line for name, value in expected.items() for line in self._wrong(name, value)]
        if wrong:
            lines = "\n".join(f"  {line}" for line in [*wrong, "the map:", *map(str, self._rows())])
            raise AssertionError(f"{self._when()}some values differ\n{lines}")
        return self

    def value(self, name: str) -> Any:
        """Returns what a name stands for; of movers as of agents, `deer.FIELD` and `deer.row`.

        `agent.FIELD`, `KIND.FIELD`: a list over agents or cells; `FIELD`: of the world; `…[word]`: one entry of a `by` field. `agent.row`,
        `agent.col`, `agent.heading`, `agent.moved`, `agent.away` (condition), `agent.ticks` (until it returns); `allowed ACTION`: may each
        agent take it; `marks PHASE`: (row, column) of the marked cells; `steps`. Of the last step: `reward`, `event NAME`, `metric NAME`,
        `terminated`, `truncated`. Raises ValueError for another name.
        """
        return self._read(name)[0]

    def under(self, agent: int) -> str:
        """Returns the sign of what an agent stands on."""
        row, column = self._place(agent)
        return draw_cells(self.stage.signs, self.stage.board, self.world)[row][column]

    def places(self) -> list[tuple[int, int] | None]:
        """Returns the (row, column) of each agent, None for one that is away."""
        return [None if place is None else (place.row, place.col) for place in self.world.position]

    def headings(self) -> list[str]:
        """Returns the heading of each agent as a word."""
        return [HEADINGS[heading] for heading in self.world.heading]

    def picture(self) -> list[str]:
        """Returns the map now, with the numbers of the agents of each row beside it."""
        return [str(row) for row in self._rows()]

    def seen(self, agent: int, plane: str, ahead: int = 0, right: int = 0) -> Any:
        """Returns what an agent sees in a plane so many cells ahead and to its right: a label, a number, or labels joined by `+`."""
        planes, window = self.env.token_planes, self.env.game.window
        names = [p.name for p in planes]
        if plane not in names:
            raise ValueError(f"there is no plane `{plane}`{meant(plane, names)}")
        self._place(agent)
        if not (-window.behind <= ahead <= window.ahead and -window.left <= right <= window.right):
            raise ValueError(f"{ahead} ahead, {right} to the right is outside the window")
        shown = planes[names.index(plane)]
        value = int(
            self.observation[agent, names.index(plane), window.ahead - ahead, window.left + right]
        )
        match shown.encoding:
            case "bits":
                return "+".join(label for bit, label in enumerate(shown.labels) if value >> bit & 1)
            case "word":
                return shown.labels[value]
            case _:
                return value

    def compare_start(self, seed: int) -> None:
        """Asserts that the compiled reset of a seed gives this scene."""
        _, self.state = self.env.reset(jax.random.key(seed), self.params)
        self._seen = look_at(self.stage.compiled, self.state, self.world, self.params)

    def _rows(self) -> list[Row]:
        return draw_picture(self.stage.signs, self.stage.board, self.world)

    def _place(self, agent: int) -> tuple[int, int]:
        place = self.places()[agent]
        if place is None:
            raise ValueError(f"agent {agent} is away")
        return place

    def _when(self) -> str:
        return f"after {self._past[2:]}: " if self._past else ""

    def _wrong(self, name: str, wanted: Any) -> list[str]:
        found, owners = self._read(name)
        if owners is None:
            return [] if same(found, wanted) else [f"{name} is {found}, not {wanted}"]
        values = dict(zip(owners, found, strict=True))
        differing = [
            owner
            for owner, value in by_owner(name, wanted, owners).items()
            if not same(values[owner], value)
        ]
        if not differing:
            return []
        return [
            f"{name} is {found}, not {wanted}"
            if len(found) <= 8
            else f"{name} of {o} is {values[o]}"
            for o in differing[: 1 if len(found) <= 8 else 5]
        ]

    def _read(self, name: str) -> tuple[Any, list[Any] | None]:
        """Returns what a name stands for, and what the entries of a list belong to."""
        agents = list(range(self.env.num_agents))
        word, _, rest = name.strip().partition(" ")
        readers: dict[str, Callable[[str], Any]] = {
            "event": self._event,
            "metric": self._metric,
            "allowed": self._allowed,
            "marks": self._marks,
        }
        if rest and word in readers:
            value = readers[word](rest)
            return value, agents if isinstance(value, list) else None
        whole = {
            "steps": self.world.step,
            "terminated": self.terminated,
            "truncated": self.truncated,
        }
        if name in whole:
            return whole[name], None
        if name == "reward":
            return self._of_last_step(self.reward), agents
        if name == "agent.heading":
            return self.headings(), agents
        sort, _, attribute = name.partition(".")
        if attribute in _ATTRIBUTES and sort in {"agent", *self.world.movers}:
            values = _ATTRIBUTES[attribute](self.world.movers.get(sort, self.world))
            return values, list(range(len(values)))
        path = find_field(self.env.game, name)
        return read_field(path, self.world), owners_of(path, self.stage.board)

    def _of_last_step(self, value: Any) -> Any:
        if not self.reward:
            raise ValueError("no step has been taken, so there are no rewards, events or metrics")
        return value

    def _event(self, name: str) -> Any:
        return self._named(name, self._of_last_step(self.events), "event")

    def _metric(self, name: str) -> Any:
        return self._named(name, self._of_last_step(self.metrics), "metric")

    def _named(self, name: str, values: Mapping[str, Any], what: str) -> Any:
        if name not in values:
            raise ValueError(f"the game has no {what} `{name}`{meant(name, values)}")
        return values[name]

    def _allowed(self, action: str) -> list[bool]:
        return list(self.allowed[:, self._chosen(action)[0]].tolist())

    def _marks(self, phase: str) -> set[tuple[int, int]]:
        names = {p.label: p.name for p in marking_phases(self.env.game)}
        if phase not in names:
            raise ValueError(f"no phase `{phase}` marks cells{meant(phase, names)}")
        return {(row, column) for name, row, column in self.world.marks if name == names[phase]}
