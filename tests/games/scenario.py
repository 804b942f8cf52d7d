"""Scenes of a game as pictures: put a map, take a step, look at what became of it.

    scene = stage.put("..A..",
                      ".>.<.  10")
    scene.step("step_left, stay")
    scene.shows("..a..", ...)

A picture is the rows of the map. Agents are `^ > v <`; their numbers may stand beside a row, left to right, and those of the
other rows count in reading order. What is under an agent is as on the map, or as `under` says. Every step is taken twice, by the compiled game
and by the reference interpreter on the same draws, and both must come out alike: places, fields, rewards, events, observations.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.interpreter.draws import Threefry
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import Cell, World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.runtime.env import Environment

from .environments import cells_of, frame_cells, on_map, places, words_of

ARROWS = "^>v<"
Look = tuple[str, str, str]  # kind, field, word


@dataclass(frozen=True)
class Stage:
    """A game on a small map. `looks`: the signs of a picture that stand for a state of a cell, beside the map's own glyphs."""

    game: str
    rows: tuple[str, ...]
    agents: int
    looks: Mapping[str, Look] = field(default_factory=dict)
    sizes: tuple[tuple[str, int], ...] = ()

    @cached_property
    def env(self) -> Environment:
        return on_map(self.game, self.rows, self.agents, self.sizes)

    def put(self, *picture: str, under: Mapping[int, str] | None = None, step: int = 0, seed: int = 0, **params: float) -> "Scene":
        """Returns the scene of a picture. `under`: the sign of what is under an agent, by its number."""
        return Scene(self, picture, under or {}, step, seed, params)


class Scene:
    """One state and what the last step gave. `reward` and `events` are lists over agents (or numbers)."""

    reward: list[float]
    events: dict[str, Any]
    metrics: dict[str, float]

    def __init__(self, stage: Stage, picture: tuple[str, ...], under: Mapping[int, str], step: int, seed: int, params: Mapping[str, float]):
        env = stage.env
        self.stage, self.env, self.seed = stage, env, seed
        self.params, self.given = env.params, default_params(env.game)
        self.change(**params)
        _, self.state = env.reset(jax.random.key(0), self.params)
        self.world: World = reset(env.game, self.given, Threefry(0, 0))
        self._put(picture, under, step)
        self.observation = np.asarray(env.observe(self.state, self.params))

    def change(self, **params: float) -> "Scene":
        """Sets parameters for the steps that follow."""
        self.params = self.params.replace(**{n: jnp.asarray(v, getattr(self.params, n).dtype) for n, v in params.items()})
        self.given |= {n: real(v) if isinstance(self.given[n], np.floating) else int(v) for n, v in params.items()}
        return self

    def step(self, actions: str) -> "Scene":
        """Takes a step: the names of the actions of agent 0, 1, …; those not named stay."""
        names = [*actions.split(", "), *["stay"] * self.env.num_agents][: self.env.num_agents]
        numbers = [self.env.action_names.index(name) for name in names]
        key, self.seed = jax.random.key(self.seed), self.seed + 1
        words = [int(w) for w in jax.random.key_data(jax.random.key(self.seed - 1))]
        self.world, out = step(self.env.game, self.world, numbers, self.given, Threefry(*words))
        observation, self.state, reward, _, info = self.env.step_env(key, self.state, jnp.array(numbers, jnp.int32), self.params)
        self.observation = np.asarray(observation)
        self.reward = np.asarray(reward).tolist()
        self.events = {name: np.asarray(value).tolist() for name, value in info["events"].items()}
        self.metrics = {name: float(value) for name, value in info["metrics"].items()}
        assert self.reward == [float(r) for r in out.reward]
        assert {name: value for name, value in self.events.items() if "[" not in name} == {
            e.name: out.events[e.name] for e in self.env.game.events if not e.by
        }
        assert self.metrics == {name: float(value) for name, value in out.measures.items()}
        self._assert_engines_agree()
        return self

    def shows(self, *picture: str) -> "Scene":
        """Asserts what the map looks like now; numbers of agents are compared in the rows that give them."""
        wanted = [row.split() for row in picture]
        drawn = [row.split() for row in self.picture()]
        found = [row[: len(want)] for row, want in zip(drawn, wanted, strict=True)]
        assert found == wanted, "\n".join(["", *self.picture()])
        return self

    def picture(self) -> list[str]:
        """Returns the map now, with the numbers of the agents of each row beside it."""
        rows = [list(row) for row in self.stage.rows]
        for sign, (kind, name, word) in self.stage.looks.items():
            for (r, c), value in zip(cells_of(self.env, kind), self.values(kind, name), strict=True):
                if value == word:
                    rows[r][c] = sign
        ids: list[list[tuple[int, int]]] = [[] for _ in rows]
        for agent, place in enumerate(self.places()):
            if place is not None:
                rows[place[0]][place[1]] = ARROWS[int(self.state.heading[agent])]
                ids[place[0]].append((place[1], agent))
        return ["".join(row) + "  " + "".join(str(a) for _, a in sorted(here)) for row, here in zip(rows, ids, strict=True)]

    def places(self) -> list[tuple[int, int] | None]:
        """Returns the (row, col) of each agent, None for one that is away."""
        found = places(self.env, self.state.position)
        return [(int(r), int(c)) if p else None for (r, c), p in zip(found, self.state.position.tolist(), strict=True)]

    def values(self, kind: str, name: str) -> list[str]:
        """Returns the word of each cell of a kind, in reading order."""
        words = words_of(self.env, kind, name)
        return [words[v] for v in np.asarray(getattr(self.state, f"{kind}_{name}")).tolist()]

    def seen(self, agent: int, plane: str, ahead: int = 0, right: int = 0) -> str:
        """Returns the label an agent sees in a plane so many cells ahead and to its right; for bits, all labels joined by `+`."""
        index = [p.name for p in self.env.token_planes].index(plane)
        shown, window = self.env.token_planes[index], self.env.game.window
        value = int(self.observation[agent, window.ahead - ahead, window.left + right, index])
        if shown.encoding == "bits":
            return "+".join(label for bit, label in enumerate(shown.labels) if value >> bit & 1)
        return shown.labels[value]

    def _put(self, picture: tuple[str, ...], under: Mapping[int, str], step: int) -> None:
        """Sets both engines to what a picture shows."""
        assert len(picture) == len(self.stage.rows), picture
        rows = [row.split() for row in picture]
        poses = numbered(rows)
        assert sorted(poses) == list(range(self.env.num_agents)), f"agents {sorted(poses)} of {self.env.num_agents}"
        signs = {(r, c): sign for r, row in enumerate(rows) for c, sign in enumerate(row[0]) if sign not in ARROWS}
        signs |= {poses[agent][:2]: sign for agent, sign in under.items()}
        position = [poses[agent][:2] for agent in range(self.env.num_agents)]
        heading = [poses[agent][2] for agent in range(self.env.num_agents)]
        self.world.position, self.world.heading = [Cell(*place) for place in position], list(heading)
        self.world.step = step
        changed: dict[str, Any] = {"step": jnp.int32(step)}
        for kind, name in {(kind, name) for kind, name, _ in self.stage.looks.values()}:
            words = words_of(self.env, kind, name)
            values = list(self.world.cells[kind, name])
            for site, cell in enumerate(cells_of(self.env, kind)):
                sign = signs.pop(cell, None)
                if sign is not None and sign != self.stage.rows[cell[0]][cell[1]]:
                    assert self.stage.looks[sign][:2] == (kind, name), (cell, sign)
                if sign in self.stage.looks:
                    values[site] = self.stage.looks[sign][2]
            self.world.cells[kind, name] = values
            changed[f"{kind}_{name}"] = jnp.array([words.index(v) for v in values], jnp.uint8)
        for (r, c), sign in signs.items():
            assert sign == self.stage.rows[r][c], f"`{sign}` at row {r}, column {c}"
        cells = jnp.asarray(frame_cells(self.env, position))
        self.state = self.state.replace(position=cells, heading=jnp.array(heading, jnp.int32), **changed)

    def _assert_engines_agree(self) -> None:
        assert self.places() == [None if place is None else tuple(place) for place in self.world.position]
        assert np.asarray(self.state.heading).tolist() == self.world.heading
        assert int(self.state.step) == self.world.step
        for (kind, name), values in self.world.cells.items():
            if values and isinstance(values[0], str):
                assert self.values(kind, name) == values
        np.testing.assert_array_equal(self.observation, observe(self.env.game, self.world))


def numbered(rows: list[list[str]]) -> dict[int, tuple[int, int, int]]:
    """Returns the (row, column, heading) of each agent of a picture by its number."""
    told = {int(number) for row in rows for number in "".join(row[1:])}
    free = iter(number for number in range(99) if number not in told)
    poses = {}
    for r, row in enumerate(rows):
        arrows = [(r, c, ARROWS.index(sign)) for c, sign in enumerate(row[0]) if sign in ARROWS]
        numbers = [int(number) for number in row[1]] if len(row) > 1 else [next(free) for _ in arrows]
        poses |= dict(zip(numbers, arrows, strict=True))
    return poses
