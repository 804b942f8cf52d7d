"""Plays thousands of worlds of the compiled game side by side on its own map, and continues those in which something new happened.

An archive keeps a world for each summary of a state. Some of the worlds play whole episodes; the others continue from the archive, more
often where a summary was seldom seen. Source of that: Ecoffet et al., "First return, then explore", Nature 590, 2021.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of, param_attribute
from sjdsl.compiler.ir.queries import body_sorts, kinds_by_glyph
from sjdsl.properties.biased_draws import BIASES, Bias
from sjdsl.properties.compiled_play import CompiledPlay, episode_keys
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import DRIFT, FLOATS, REAL
from sjdsl.properties.random_play import MOVES, random_params
from sjdsl.properties.statements import StatementId
from sjdsl.properties.trajectory import Scenario
from sjdsl.properties.verdict import Effort, Progress

WORK = (
    2**19 + 2**17
)  # cells of the map times steps, of all worlds together, for each trajectory that is asked for
SMALL = 32  # cells; a smaller map takes as long
AT_ONCE = 2**17  # cells of all worlds together
MOST, LEAST = 2048, 64  # worlds
WHOLE = 4  # one in so many worlds plays whole episodes
UNFAIR = 0.5  # how often the draws of a segment may be biased
QUIET = 0.2  # how often all agents of a world only move for STEPS steps; in half of the whole episodes they always do
STEPS = 4  # of every world between two looks at what happened
KEPT = 4  # times as many worlds in the archive as are played at once
AGES = 8  # parts of an episode that a summary tells apart
SETS = 32  # of parameters for the worlds that begin together; the first half are the file's
HABITS = (0.0, 0.5, 0.9)  # how often an agent repeats its habitual action for STEPS steps
ALIKE = 0.1  # how often all agents of a world do the same
COUNTED = 8  # values of a small field, or entries of a small table, that a summary tells apart


class Worlds(NamedTuple):
    """Worlds side by side, each array with an axis of them in front.

    first: the values of all checks in the first state `[K]`; triggered: of each check, whether the first condition of a `once` has held.
    given: which set of parameters; episode: the number that its random draws come from. node: the last segment of its past; -1: none.
    """

    state: Any
    totals: dict[str, np.ndarray]
    params: Any
    first: np.ndarray
    triggered: np.ndarray
    given: np.ndarray
    episode: np.ndarray
    node: np.ndarray


class Segment(NamedTuple):
    """STEPS steps of all worlds: the node before each, the bias of its draws, the actions `[B, STEPS, N]`."""

    before: np.ndarray
    bias: np.ndarray
    actions: np.ndarray


@dataclass
class WorldSearch:
    """Looks for violations of checks about states, by their index among the game's checks, and of the range of float32.

    steps: taken so far, by all worlds; ran: the statements that ran, of those that can be counted; triggered: each `once` whose first
    condition has held.
    """

    family: GameFamily
    numbers: Sequence[int]
    effort: Effort
    progress: Progress
    steps: int = 0
    ran: set[StatementId] = field(default_factory=set)
    triggered: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        game = self.family.own
        self._checks = [game.checks[number] for number in self.numbers]
        self._left = {FLOATS, *self.numbers}
        self._program = Program(self.family, self._checks)
        cells = max(SMALL, len(game.rows) * len(game.rows[0]))
        self.worlds = max(LEAST, min(MOST, 2 ** ((AT_ONCE // cells).bit_length() - 1)))
        self._segments = (
            max(self.effort.examples * WORK // (cells * self.worlds), self._program.length) // STEPS
            + 1
        )
        self._random, self._rng = Random(self.effort.seed), np.random.default_rng(self.effort.seed)
        self._sets: list[tuple[tuple[str, Any], ...]] = []
        self._past: list[Segment] = []
        self._begun = 0

    def run(self, is_enough: Callable[[set[StatementId]], bool]) -> Iterator[tuple[int, Scenario]]:
        """Yields each check that is violated with what leads to that.

        It ends when all work is done, or all checks are violated and it `is_enough` that these statements have run.
        """
        rng, whole = self._rng, self.worlds // WHOLE
        worlds, spare, archive = self._begin(), np.arange(0), Archive(KEPT * self.worlds)
        for number in range(self._segments):
            self.progress(f"{self.steps} steps of random play")
            bias = self._bias(worlds.episode, whole)
            actions = self._actions(
                (rng.random(self.worlds) < QUIET)
                | (np.arange(self.worlds) < whole) & (worlds.episode // 8 % 2 == 1)
            )
            played = self._program.play(worlds, bias, self.effort.seed, actions)
            self._past.append(
                Segment(worlds.node, bias.astype(np.uint8), actions.astype(np.uint16))
            )
            self.steps += self.worlds * STEPS
            self.ran |= {self._program.statements[i] for i in np.flatnonzero(played.ran.any(0))}
            wrong, triggered = self._wrong(worlds, played)
            for check, bad in wrong:
                if check in self._left and bad.any():
                    world = int(np.where(bad.any(1), bad.argmax(1), STEPS).argmin())
                    self._left.remove(check)
                    yield check, self._scenario(worlds, number, world, int(bad[world].argmax()) + 1)
            if self._left <= {FLOATS} and is_enough(self.ran):
                return
            node = number * self.worlds + np.arange(self.worlds)
            worlds = worlds._replace(
                state=played.state, totals=played.totals, triggered=triggered, node=node
            )
            archive.add(worlds, np.flatnonzero(~played.over), played.summary)
            ended = np.flatnonzero(played.over[:whole])
            if len(ended) > len(spare):
                fresh, spare = self._begin(), np.arange(self.worlds)
            if len(ended):
                _put(worlds, ended, fresh, spare[: len(ended)])
                spare = spare[len(ended) :]
            if archive.rows:
                chosen = archive.choose(self.worlds - whole, rng)
                _put(worlds, np.arange(whole, self.worlds), archive.worlds, chosen)

    def _begin(self) -> Worlds:
        """Returns worlds at the start of episodes."""
        sets = [
            () if i < SETS // 2 else random_params(self.family.own, self._random)
            for i in range(SETS)
        ]
        given = len(self._sets) + np.arange(self.worlds) % SETS
        self._sets += sets
        episode = self._begun + np.arange(self.worlds)
        self._begun += self.worlds
        return self._program.begin(
            [sets[i % SETS] for i in range(self.worlds)], given, episode, self.effort.seed
        )

    def _bias(self, episode: np.ndarray, whole: int) -> np.ndarray:
        """Returns the bias of the draws of each world; half of the whole episodes have one bias throughout."""
        changing = self._rng.integers(0, len(BIASES), self.worlds) * (
            self._rng.random(self.worlds) < UNFAIR
        )
        steady = (np.arange(self.worlds) < whole) & (episode % 2 == 1)
        return np.where(steady, episode // 2 % len(BIASES), changing).astype(np.uint32)

    def _actions(self, quiet: np.ndarray) -> np.ndarray:
        """Returns random actions, `[B, STEPS, N]` int32: some worlds have agents with habits, in some all do the same. quiet: only moves."""
        rng, shape, names = (
            self._rng,
            (self.worlds, STEPS, self._program.agents),
            self.family.own.agents.actions,
        )
        moves = np.array([action for action, name in enumerate(names) if name in MOVES])
        any_action, habit = (
            np.where(
                quiet[:, None, None], rng.choice(moves, size), rng.integers(0, len(names), size)
            )
            for size in (shape, (self.worlds, 1, shape[2]))
        )
        actions = np.where(
            rng.random(shape) < rng.choice(HABITS, (self.worlds, 1, 1)), habit, any_action
        )
        return np.where(rng.random((self.worlds, 1, 1)) < ALIKE, actions[:, :, :1], actions).astype(
            np.int32
        )

    def _wrong(
        self, worlds: Worlds, played: "Played"
    ) -> tuple[list[tuple[int, np.ndarray]], np.ndarray]:
        """Returns the steps `[B, STEPS]` in which each check is violated, and the worlds `[B, K]` in which a `once` applies from now on."""
        live, triggered = ~played.was_over, worlds.triggered.copy()
        wrong, at = [(FLOATS, live & ~played.finite)], 0
        for i, (number, check) in enumerate(zip(self.numbers, self._checks, strict=True)):
            values = played.values[:, :, at : at + len(check.values)]
            first = worlds.first[:, None, at : at + len(check.values)]
            at += len(check.values)
            match check.sort:
                case "always":
                    bad = values[:, :, 0] == 0
                case "conserved":
                    bad = ~np.isclose(values, first, DRIFT, DRIFT)[:, :, 0]
                case "once":
                    holds = (
                        np.logical_or.accumulate(live & (values[:, :, 0] != 0), 1)
                        | triggered[:, i, None]
                    )
                    self.triggered |= {number} if holds.any() else set()
                    triggered[:, i], bad = holds[:, -1], holds & (values[:, :, 1] == 0)
                case _:
                    bad = _wrong_ways(
                        np.concatenate([first, values], 1), check.words[0] == "rising"
                    )
            wrong.append((number, live & bad & played.finite.cumprod(1, dtype=bool)))
        return wrong, triggered

    def _scenario(self, worlds: Worlds, segment: int, world: int, steps: int) -> Scenario:
        """Returns what the interpreter has to play to come to the state of a world after so many steps of the latest segment."""
        node = segment * self.worlds + world
        past = list[tuple[Bias, tuple[int, ...]]]()
        while node >= 0:
            one, i = self._past[node // self.worlds], node % self.worlds
            past = [
                (BIASES[one.bias[i]], tuple(actions)) for actions in one.actions[i].tolist()
            ] + past
            node = int(one.before[i])
        past = past[: len(past) - STEPS + steps]
        bias, actions = tuple(bias for bias, _ in past), tuple(actions for _, actions in past)
        return Scenario(
            self.effort.seed,
            int(worlds.episode[world]),
            self._sets[worlds.given[world]],
            bias,
            actions,
        )


class Archive:
    """The latest world of each summary, in the row of that; how often the summary was seen, and how often its world was continued."""

    def __init__(self, most: int) -> None:
        self.rows, self.worlds, self._most = dict[int, int](), cast(Any, None), most
        self._seen, self._continued = np.zeros(most), np.zeros(most)

    def add(self, worlds: Worlds, which: np.ndarray, summary: np.ndarray) -> None:
        """Keeps a world of each summary; where there is no more room, in place of those that were seen most often."""
        summaries, at, times = np.unique(summary[which], return_index=True, return_counts=True)
        if self.worlds is None:
            self.worlds = jax.tree.map(
                lambda x: np.zeros((self._most, *x.shape[1:]), x.dtype), worlds
            )
        new = [s for s in summaries.tolist() if s not in self.rows]
        if more := max(0, len(self.rows) + len(new) - self._most):
            names = list(self.rows)
            order = np.argsort([-self._seen[row] for row in self.rows.values()], kind="stable")
            free = [self.rows.pop(names[i]) for i in order[:more]]
        else:
            free = []
        free += range(len(self.rows) + len(free), len(self.rows) + len(new))
        self.rows |= dict(zip(new, free, strict=True))
        self._seen[free] = self._continued[free] = 0
        rows = np.array([self.rows.get(s, -1) for s in summaries.tolist()], int)
        kept = rows >= 0  # a summary of these worlds can be among those that made room
        self._seen[rows[kept]] += times[kept]
        _put(self.worlds, rows[kept], worlds, which[at[kept]])

    def choose(self, many: int, rng: np.random.Generator) -> np.ndarray:
        """Returns the rows of worlds to continue, more often those seldom seen and seldom continued."""
        number = len(self.rows)
        weights = 1 / np.sqrt((1 + self._seen[:number]) * (1 + self._continued[:number]))
        rows = rng.choice(number, many, p=weights / weights.sum())
        np.add.at(self._continued, rows, 1)
        return rows


class Played(NamedTuple):
    """What a segment leads to.

    state, totals: the last ones; over `[B]`: whether the episode has ended. values `[B, STEPS, K]`, was_over and finite `[B, STEPS]`: of
    each step, whether the episode had ended before, and whether all its numbers are finite. ran `[B, S]`: whether each statement ran.
    summary `[B]` uint32: of the last state and of what ran.
    """

    state: Any
    totals: dict[str, np.ndarray]
    over: np.ndarray
    values: np.ndarray
    was_over: np.ndarray
    finite: np.ndarray
    ran: np.ndarray
    summary: np.ndarray


class Program:
    """The compiled game, for worlds side by side."""

    def __init__(self, family: GameFamily, checks: Sequence[ir.Check]):
        self._play, self._game, self._checks = CompiledPlay(family, checks), family.own, len(checks)
        env = self._play.env
        self.statements, self._module = list(self._play.counted.values()), self._play.module
        self.agents, self.length = env.num_agents, env.episode_length
        self._kinds = self._kind_of_place()
        self._segment = jax.jit(jax.vmap(self._played))
        self._start = jax.jit(jax.vmap(self._play.begin))

    def begin(
        self,
        sets: Sequence[tuple[tuple[str, Any], ...]],
        given: np.ndarray,
        episode: np.ndarray,
        seed: int,
    ) -> Worlds:
        """Returns the first states of some episodes, with these parameters."""
        own = self._play.env.params
        names = {p.name: param_attribute(p.name) for p in self._game.params}
        types = {p.name: p.type for p in self._game.params}
        different = [{names[n]: _stored(value, types[n]) for n, value in one} for one in sets]
        values = {
            name: [
                np.asarray(one.get(name, getattr(own, name)), getattr(own, name).dtype)
                for one in different
            ]
            for name in names.values()
        }
        params = replace(own, **{name: np.stack(value) for name, value in values.items()})
        state, totals, first = jax.tree.map(
            np.array, self._start(params, episode_keys(seed, episode))
        )
        triggered = np.zeros((len(episode), self._checks), np.bool_)
        return Worlds(
            state, totals, params, first, triggered, given, episode, np.full(len(episode), -1)
        )

    def play(self, worlds: Worlds, bias: np.ndarray, seed: int, actions: np.ndarray) -> Played:
        """Plays STEPS steps of each world."""
        played = self._segment(
            worlds.state,
            worlds.totals,
            worlds.params,
            episode_keys(seed, worlds.episode),
            bias,
            actions,
        )
        return Played(*jax.tree.map(np.array, played))

    def _played(
        self,
        state: Any,
        totals: dict[str, Array],
        params: Any,
        key: Array,
        bias: Array,
        actions: Array,
    ) -> tuple[Any, ...]:
        def advance(carry: Any, chosen: Array) -> Any:
            before, earlier, over = carry
            after = self._play.step(before, earlier, params, key, bias, chosen)
            ran = jnp.array([after.events[name] > 0 for name in self._play.counted], bool) & ~over
            state, totals = jax.tree.map(
                lambda old, new: jnp.where(over, old, new),
                (before, earlier),
                (after.state, after.totals),
            )
            return (state, totals, over | after.over), (after.values, over, after.finite, ran)

        (state, totals, over), (values, was_over, finite, ran) = jax.lax.scan(
            advance, (state, totals, jnp.bool_(False)), actions
        )
        return (
            state,
            totals,
            over,
            values,
            was_over,
            finite,
            ran.any(0),
            self._summary(state, values[-1], ran.any(0), params),
        )

    def _summary(self, state: Any, values: Array, ran: Array, params: Any) -> Array:
        """Returns a hash of a state: its fields, the kinds on which agents and movers are, what checks read, the part of the episode; and of what ran."""
        sorts = body_sorts(self._game)
        places = {attribute_of("position", sort) for sort in sorts}
        left_out = {
            attribute_of(name, sort)
            for name in ("heading", "moved", "away", "away_pool", "away_facing")
            for sort in sorts
        } | {"step"}
        age = state.step * AGES // jnp.maximum(1, self._module.episode_length(params))
        parts = [age, _some(jnp.where(jnp.isfinite(values), values, 0)), ran]
        for name in state.__dataclass_fields__:
            if name not in left_out and not name.startswith("mark_"):
                held = getattr(state, name)
                parts.append(_counts(_some(self._kinds[held] if name in places else held)))
        numbers = jnp.concatenate([part.reshape(-1).astype(jnp.int32) for part in parts]).astype(
            jnp.uint32
        )
        factors = np.random.default_rng(0).integers(0, 2**32, numbers.size, np.uint32) | np.uint32(
            1
        )
        mixed = (numbers + np.uint32(COUNTED)) * factors
        return jnp.sum((mixed ^ (mixed >> 15)) * np.uint32(0x9E3779B1))

    def _kind_of_place(self) -> Array:
        """Returns a number for the kind of each cell of the map with its frame; 0: none, where those are who are away."""
        game, module = self._game, self._play.env.module
        of_glyph, names = kinds_by_glyph(game), [kind.name for kind in game.kinds]
        framed = np.zeros(module.FRAME, np.int32)
        for r, row in enumerate(game.rows):
            for c, glyph in enumerate(row):
                framed[r + module.PAD, c + module.PAD] = 1 + names.index(of_glyph[glyph])
        return jnp.asarray(framed.reshape(-1))


def _stored(value: Any, type_: ir.Type) -> Any:
    """Returns the value of a parameter as a module holds it."""
    if isinstance(value, tuple):
        return [_stored(entry, type_) for entry in value]
    return type_.words.index(value) if type_.kind == "word" else value


def _some(numbers: Array) -> Array:
    """Returns whole numbers, those of large size alike; of reals the whole part."""
    whole = jnp.floor(numbers) if jnp.issubdtype(numbers.dtype, jnp.floating) else numbers
    return jnp.clip(whole.astype(jnp.int32), -COUNTED, COUNTED)


def _counts(numbers: Array) -> Array:
    """Returns the numbers, sorted; of many, how often each is there, in steps that grow with the number."""
    flat = numbers.reshape(-1)
    if flat.size <= COUNTED:
        return jnp.sort(flat)
    times = jnp.stack([jnp.sum(flat == number) for number in range(-1, COUNTED + 1)])
    return jnp.floor(2 * jnp.log2(1 + times.astype(jnp.float32))).astype(jnp.int32)


def _put(into: Worlds, places: np.ndarray, worlds: Worlds, which: np.ndarray) -> None:
    """Replaces some worlds by others."""
    for old, new in zip(jax.tree.leaves(into), jax.tree.leaves(worlds), strict=True):
        old[places] = new[which]


def _wrong_ways(pairs: np.ndarray, rising: bool) -> np.ndarray:
    """Returns the steps `[B, STEPS]` in which the value went the wrong way since an earlier state of the segment.

    pairs: `[B, STEPS + 1, 2]`, value and argument. rising: whether it is wrong that the value moves against the argument, or with it.
    """
    value, argument = (pairs[:, :, i] for i in (0, 1))
    more, less = ((x[:, 1:, None] - x[:, None]) for x in (value, argument))
    apart = [~np.isclose(x[:, 1:, None], x[:, None], REAL, REAL) for x in (value, argument)]
    earlier = np.arange(pairs.shape[1] - 1)[:, None] >= np.arange(pairs.shape[1])[None]
    wrong = (more * less < 0) if rising else (more * less > 0)
    return np.asarray((wrong & apart[0] & apart[1] & earlier).any(2))
