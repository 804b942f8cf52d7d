"""Ways to play an example, seen alike: the reference interpreter, and the compiled step on JAX and on NumPy."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from sjdsl.compiler import Build, ir
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import Cell, default_params
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.policies.interpreted import choose
from tests.fuzz import numpy_jax

HEADINGS = ("north", "east", "south", "west")
QUICK = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}  # compiling costs more than these runs
STEADY = (0, 2**32 - 1)  # with these random numbers no policy draws a move
Key = tuple[int, int]
Place = tuple[int, int] | None


class Picture(NamedTuple):
    """What a picture of a map shows: agents in reading order, their headings, fields of cells, and movers of each sort in reading order."""

    places: Sequence[Place]
    heading: Sequence[str]
    cells: dict[tuple[str, str], list[Any]]
    herds: dict[str, list[Place]]


@dataclass
class View:
    """What can be seen of a game after a reset or a step, as plain values: words as texts, agents as numbers.

    cells: (kind, field) -> a value for each cell, and (sort, field) for each mover. herds: where the movers of each sort are. events: name or `name[word]` -> a count, or one for each agent.
    away: ticks until each agent returns, 0 for those here and those removed. observation: agents x rows x columns x planes;
    None, as `allowed`, where the compiled step has not looked (after a picture). chosen: what each agent would do under each policy of
    the file, no move of it drawn; None of the compiled step.
    """

    steps: int
    places: list[Place]
    heading: list[str]
    away: list[int]
    cells: dict[tuple[str, str], list[Any]]
    agents: dict[str, list[Any]]
    world: dict[str, Any]
    allowed: list[list[bool]] | None
    observation: np.ndarray | None
    reward: list[float] = field(default_factory=list)
    events: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, float] = field(default_factory=dict)
    truncated: bool = False
    terminated: bool = False
    chosen: dict[str, list[str]] | None = None
    herds: dict[str, list[Place]] = field(default_factory=dict)


class Play(Protocol):
    """One run of a game."""

    def reset(self, key: Key) -> View: ...

    def arrange(self, picture: Picture) -> View:
        """Puts agents, movers and cells as a picture shows them."""
        ...

    def step(self, actions: Sequence[int], key: Key) -> View: ...


class Interpreted:
    """A run in the reference interpreter. `params`: values by name, nested as the interpreter keeps them."""

    def __init__(self, built: Build, params: dict[str, Any]):
        self.game = built.game
        self.params = default_params(self.game) | params

    def reset(self, key: Key) -> View:
        self.world = reset(self.game, self.params, Threefry(*key))
        return self._view()

    def arrange(self, picture: Picture) -> View:
        for sort, at in picture.herds.items():
            self.world.movers[sort].position = [None if p is None else Cell(*p) for p in at]
        self.world.position = [None if p is None else Cell(*p) for p in picture.places]
        self.world.heading = [HEADINGS.index(h) for h in picture.heading]
        self.world.cells |= {key: list(values) for key, values in picture.cells.items()}
        return self._view()

    def step(self, actions: Sequence[int], key: Key) -> View:
        self.world, out = step(self.game, self.world, actions, self.params, Threefry(*key))
        view = self._view()
        view.reward = [float(r) for r in out.reward]
        view.events = _events(self.game, out.events.__getitem__)
        view.metrics = {name: float(value) for name, value in out.measures.items()}
        view.truncated, view.terminated = out.truncated and not out.terminated, out.terminated
        return view

    def _view(self) -> View:
        world = self.world
        fields = world.cells | {(sort, name): values for sort, herd in world.movers.items() for name, values in herd.fields.items()}
        return View(
            steps=world.step,
            places=[None if p is None else (p.row, p.col) for p in world.position],
            heading=[HEADINGS[h] for h in world.heading],
            away=[0 if a is None else a.ticks for a in world.away],
            cells={key: [_plain(v) for v in values] for key, values in fields.items()},
            herds={sort: [None if p is None else (p.row, p.col) for p in herd.position] for sort, herd in world.movers.items()},
            agents={name: [_plain(v) for v in values] for name, values in world.agents.items()},
            world={name: _plain(v) for name, v in world.fields.items()},
            allowed=action_mask(self.game, world),
            observation=observe(self.game, world),
            chosen={policy.name: [self._choice(policy, agent) for agent in range(len(world.position))] for policy in self.game.policies},
        )

    def _choice(self, policy: ir.ScriptedPolicy, agent: int) -> str:
        return self.game.agents.actions[choose(policy, self.game, self.world, agent, STEADY)]


def _plain(value: Any) -> Any:
    """Returns a value of the interpreter without NumPy, rows as lists."""
    if isinstance(value, tuple):
        return [_plain(v) for v in value]
    return float(value) if isinstance(value, np.floating) else value


def _events(game: ir.Game, count_of: Callable[[str], Any]) -> dict[str, Any]:
    """Returns the counts of events by name, of a row entry by entry."""
    found: dict[str, Any] = {}
    for event in game.events:
        count = np.asarray(count_of(event.name))
        if event.by is None:
            found[event.name] = count.tolist()
        for number, word in enumerate(event.by.keys if event.by else ()):
            found[f"{event.name}[{word}]"] = count[..., number].tolist()
    return found


def plane_names(game: ir.Game) -> dict[str, tuple[int, tuple[str, ...]]]:
    """Returns for each plane of an observation its number and labels."""
    return {plane.name: (number, plane.labels) for number, plane in enumerate(planes(game))}


class Compiled:
    """A run of the compiled step, one `jit` for step and view together."""

    def __init__(self, built: Build, text: str, params: dict[str, Any]):
        import jax

        from sjdsl.factory import load_module
        from sjdsl.parameters import build_params

        self.game = built.game
        self.module = load_module(text, f"<{self.game.name}>", self.game.name)
        self.params = build_params(self.game, self.module, params)
        self.begin = jax.jit(self._begin, compiler_options=QUICK)
        self.run = jax.jit(self._run, compiler_options=QUICK)

    def _begin(self, key: Any) -> Any:
        state = self.module.reset(self.params, key)
        return state, self._look(state)

    def _run(self, state: Any, actions: Any, key: Any) -> Any:
        state, out = self.module.step(state, actions, self.params, key)
        measures = self.module.measures(state, self.params)
        state = state.replace(step=state.step + 1)
        return state, out, measures, state.step >= self.module.episode_length(self.params), self._look(state)

    def _look(self, state: Any) -> Any:
        return self.module.allowed_actions(state, self.params), self.module.observe(state, self.params)

    def reset(self, key: Key) -> View:
        self.state, seen = self.begin(np.array(key, np.uint32))
        return self._view(seen)

    def arrange(self, picture: Picture) -> View:
        from sjdsl.compiler.ir.names import attribute_name

        (_, cols), pad = self.module.FRAME, self.module.PAD
        changed: dict[str, Any] = {
            f"{sort}_position".lstrip("_"): np.array([0 if p is None else (p[0] + pad) * cols + p[1] + pad for p in at], np.int32)
            for sort, at in {"": picture.places, **picture.herds}.items()
        }
        changed["heading"] = np.array([HEADINGS.index(h) for h in picture.heading], np.int32)
        for (kind, name), values in picture.cells.items():
            declared = next(f for k in self.game.kinds if k.name == kind for f in k.fields if f.name == name)
            attribute = attribute_name(declared)
            coded = [declared.type.words.index(v) if declared.type.kind == "word" else v for v in values]
            changed[attribute] = np.array(coded, getattr(self.state, attribute).dtype)
        self.state = self.state.replace(**changed)
        return self._view(None)

    def step(self, actions: Sequence[int], key: Key) -> View:
        from sjdsl.compiler.ir.names import param_attribute

        self.state, out, measures, last, seen = self.run(self.state, np.array(actions, np.int32), np.array(key, np.uint32))
        view = self._view(seen)
        view.reward = [float(r) for r in out.reward]
        view.events = _events(self.game, lambda name: getattr(out, f"event_{param_attribute(name)}"))
        view.metrics = {name: float(value) for name, value in measures.items()}
        view.terminated = bool(out.ended)
        view.truncated = bool(last) and not view.terminated
        return view

    def _view(self, seen: Any) -> View:
        state, (_, cols), pad = self.state, self.module.FRAME, self.module.PAD
        allowed, observation = (None, None) if seen is None else map(np.asarray, seen)
        at = {
            sort: np.asarray(getattr(state, f"{sort}_position".lstrip("_"))).tolist() for sort in ("", *(m.name for m in self.game.movers))
        }
        herds = {sort: [None if p == 0 else (p // cols - pad, p % cols - pad) for p in some] for sort, some in at.items()}
        places = herds.pop("")
        return View(
            steps=int(state.step),
            places=places,
            heading=[HEADINGS[h] for h in np.asarray(state.heading).tolist()],
            away=np.asarray(getattr(state, "away", np.zeros(len(places), int))).tolist(),
            cells={(k.name, f.name): self._values(f) for k in (*self.game.kinds, *self.game.movers) for f in k.fields},
            herds=herds,
            agents={f.name: self._values(f) for f in self.game.agents.fields},
            world={f.name: self._values(f) for f in self.game.fields},
            allowed=None if allowed is None else allowed.tolist(),
            observation=observation,
        )

    def _values(self, declared: ir.VarField) -> Any:
        from sjdsl.compiler.ir.names import attribute_name

        return _decoded(np.asarray(getattr(self.state, attribute_name(declared))).tolist(), declared.type, self.game.agents.number)


class OnNumPy(Compiled):
    """A run of the compiled step with NumPy in the place of JAX: nothing is compiled by XLA."""

    def __init__(self, built: Build, text: str, params: dict[str, Any]):
        from sjdsl.parameters import build_params

        self.game = built.game
        self.module = numpy_jax.load(text, self.game.name)
        self.params = _arrays(build_params(self.game, self.module, params))

    def begin(self, key: Any) -> Any:
        with np.errstate(all="ignore"):  # what a guard protects is computed and not used
            return self._begin(numpy_jax.as_array(key))

    def run(self, state: Any, actions: Any, key: Any) -> Any:
        with np.errstate(all="ignore"):
            return self._run(_arrays(state), *map(numpy_jax.as_array, (actions, key)))


def _arrays(values: Any) -> Any:
    """Returns a state or parameters with arrays that are indexed as JAX's are."""
    return values.replace(**{name: numpy_jax.as_array(value) for name, value in vars(values).items()})


def _decoded(value: Any, type_: ir.Type, agents: int) -> Any:
    """Returns a stored value as the interpreter has it."""
    if isinstance(value, list):
        return [_decoded(v, type_, agents) for v in value]
    match type_.kind:
        case "word":
            return type_.words[value]
        case "agent":
            return None if value < 0 else value
        case "cell":
            return None if value < 0 else list(divmod(value, 256))
        case "agents":
            return frozenset(i for i in range(agents) if value >> i & 1)
        case _:
            return value
