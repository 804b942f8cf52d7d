"""Plays thousands of worlds of the compiled game side by side on its own map.

An archive keeps a world for each summary of a state. Some worlds play whole episodes; the others
continue from the archive, more often where a summary was seldom seen. Source of that: Ecoffet et
al., "First return, then explore", Nature 590, 2021.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of, param_attribute
from sjdsl.compiler.ir.queries import body_types, kinds_by_glyph
from sjdsl.properties.biased_draws import BIASES, Bias
from sjdsl.properties.compiled_play import FAIR, CompiledPlay, episode_keys
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import DRIFT, FLOATS, REAL
from sjdsl.properties.random_play import MOVES, random_params
from sjdsl.properties.statements import StatementId
from sjdsl.properties.trajectory import Scenario
from sjdsl.properties.verdict import Effort, Progress

# Cells of the map times steps, of all worlds together, for each example of the effort.
WORK = 2**19 + 2**17
SMALL = 32  # cells; a smaller map takes as long
AT_ONCE = 2**17  # cells of all worlds together
MOST = 2048  # worlds
LEAST = 64
WHOLE = 4  # one in so many worlds plays whole episodes
STEPS = 4  # of a segment, after which all worlds are looked at
UNFAIR = 0.5  # how often the draws of a segment may be biased
# How often all agents of a world only move in a segment; in half of the whole episodes they always
# do.
QUIET = 0.2
HABITS = (0.0, 0.5, 0.9)  # how often an agent repeats its habitual action in a segment
ALIKE = 0.1  # how often all agents of a world do the same
SETS = 32  # of parameters for the worlds that begin together; the first half are the file's
KEPT = 4  # times as many worlds in the archive as are played at once
AGES = 8  # parts of an episode that a summary tells apart
COUNTED = 8  # values of a small field, or entries of a small table, that a summary tells apart
Params = tuple[tuple[str, Any], ...]  # that differ from the file's


class Worlds(NamedTuple):
    """Worlds side by side, each array with an axis of them in front.

    first_values: `[B, K]`, of the checks in the first state; triggered: `[B, C]`, whether the first
    condition of a `once` has held, for each check.
    params_set `[B]`: index of its parameters in WorldSearch; episode `[B]`: number from which its
    random draws come.
    node `[B]`: the last segment of its past, -1 for none: segment * B + its place among the worlds.
    """

    state: Any
    totals: dict[str, np.ndarray]
    params: Any
    first_values: np.ndarray
    triggered: np.ndarray
    params_set: np.ndarray
    episode: np.ndarray
    node: np.ndarray


class Segment(NamedTuple):
    """STEPS steps of all worlds: the node before each and the bias of its draws, `[B]`.

    Actions `[B, STEPS, N]`.
    """

    before: np.ndarray
    bias: np.ndarray
    actions: np.ndarray


@dataclass
class WorldSearch:
    """Looks for violations of checks about states, and for reals that leave float32.

    numbers: of the checks. steps: taken so far, by all worlds; ran: the statements that ran, of
    those that can be counted; triggered: each `once` whose first condition has held.
    """

    family: GameFamily
    numbers: Sequence[int]
    effort: Effort
    progress: Progress
    steps: int = 0
    ran: set[StatementId] = field(default_factory=set)
    triggered: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        """Plans the play.

        How many worlds side by side, how many of them whole episodes, how long.
        """
        game = self.family.own
        self._checks = [game.checks[number] for number in self.numbers]
        self._left = {FLOATS, *self.numbers}
        self._program = Program(self.family, self._checks)
        cells = max(SMALL, len(game.rows) * len(game.rows[0]))
        power_of_two = 2 ** ((AT_ONCE // cells).bit_length() - 1)
        self.worlds = max(LEAST, min(MOST, power_of_two))
        self._whole = self.worlds // WHOLE  # so many, the first ones, play whole episodes
        self._plays_whole: np.ndarray = np.arange(self.worlds) < self._whole
        steps = max(self.effort.examples * WORK // (cells * self.worlds), self._program.length)
        self._segments = steps // STEPS + 1
        self._random = Random(self.effort.seed)
        self._rng = np.random.default_rng(self.effort.seed)
        self._params_sets: list[Params] = []
        self._past: list[Segment] = []
        self._num_begun = 0

    def run(self, is_enough: Callable[[set[StatementId]], bool]) -> Iterator[tuple[int, Scenario]]:
        """Yields each check that is violated with what leads to that.

        It ends when all work is done, or all checks are violated and it `is_enough` that these
        statements have run.
        """
        rng = self._rng
        whole = self._whole
        worlds = self._begin()
        fresh = worlds
        spare = np.arange(0)  # places of `fresh` worlds that aren't played yet
        archive = Archive(KEPT * self.worlds)
        for number in range(self._segments):
            self.progress(f"{self.steps} steps of random play")
            bias = self._choose_bias(worlds.episode)
            actions = self._choose_actions(self._are_quiet(worlds.episode))
            played = self._program.play(worlds, bias, self.effort.seed, actions)
            segment = Segment(worlds.node, bias.astype(np.uint8), actions.astype(np.uint16))
            self._past.append(segment)
            self.steps += self.worlds * STEPS
            for i in np.flatnonzero(played.ran.any(axis=0)):
                self.ran.add(self._program.statements[i])
            violations, triggered = self._violations(worlds, played)
            for check, is_violated in violations:
                if check in self._left and is_violated.any():
                    in_world = is_violated.any(axis=1)
                    first_step = is_violated.argmax(axis=1)
                    world = int(np.where(in_world, first_step, STEPS).argmin())
                    self._left.remove(check)
                    yield check, self._scenario(worlds, number, world, int(first_step[world]) + 1)
            if self._left <= {FLOATS} and is_enough(self.ran):
                return
            node = number * self.worlds + np.arange(self.worlds)
            worlds = worlds._replace(
                state=played.state, totals=played.totals, triggered=triggered, node=node
            )
            archive.add(worlds, np.flatnonzero(~played.is_over), played.summary)
            ended = np.flatnonzero(played.is_over[:whole])
            if len(ended) > len(spare):
                fresh = self._begin()
                spare = np.arange(self.worlds)
            if len(ended):
                _put(worlds, ended, fresh, spare[: len(ended)])
                spare = spare[len(ended) :]
            if archive.rows:
                chosen = archive.choose(self.worlds - whole, rng)
                _put(worlds, np.arange(whole, self.worlds), archive.worlds, chosen)

    def _begin(self) -> Worlds:
        """Returns worlds at the start of episodes."""
        params_sets: list[Params] = [()] * (SETS // 2)
        for _ in range(SETS - len(params_sets)):
            params_sets.append(random_params(self.family.own, self._random))
        places = np.arange(self.worlds)
        params_set = len(self._params_sets) + places % SETS
        self._params_sets += params_sets
        episode = self._num_begun + places
        self._num_begun += self.worlds
        params = [self._params_sets[i] for i in params_set]
        return self._program.begin(params, params_set, episode, self.effort.seed)

    def _choose_bias(self, episode: np.ndarray) -> np.ndarray:
        """Returns the bias of the draws of each world in a segment, `[B]` uint32.

        Of the worlds that play whole episodes, every second episode has one bias throughout; these
        take the biases in turn. Elsewhere a segment has any bias, or none.
        """
        any_bias = self._rng.integers(0, len(BIASES), self.worlds)
        changing = np.where(self._rng.random(self.worlds) < UNFAIR, any_bias, FAIR)
        is_steady = self._plays_whole & (episode % 2 == 1)
        bias: np.ndarray = np.where(is_steady, episode // 2 % len(BIASES), changing)
        return bias.astype(np.uint32)

    def _are_quiet(self, episode: np.ndarray) -> np.ndarray:
        """Returns in which worlds all agents only move in a segment, `[B]` bool.

        Of whole episodes, every other eight do so throughout.
        """
        at_random = self._rng.random(self.worlds) < QUIET
        is_steady = self._plays_whole & (episode // 8 % 2 == 1)
        are_quiet: np.ndarray = at_random | is_steady
        return are_quiet

    def _choose_actions(self, are_quiet: np.ndarray) -> np.ndarray:
        """Returns random actions, `[B, STEPS, N]` int32.

        In some worlds the agents have habits, in some all do the same, in `are_quiet` all move.
        """
        rng = self._rng
        names = self.family.own.agents.actions
        moves = np.array([action for action, name in enumerate(names) if name in MOVES])

        def choose(steps: int) -> np.ndarray:
            """Returns random actions, `[B, steps, N]`."""
            shape = (self.worlds, steps, self._program.agents)
            any_move = rng.choice(moves, shape)
            any_action = rng.integers(0, len(names), shape)
            chosen: np.ndarray = np.where(are_quiet[:, None, None], any_move, any_action)
            return chosen

        changing = choose(STEPS)
        habit = choose(1)
        follows_habit = rng.random(changing.shape) < rng.choice(HABITS, (self.worlds, 1, 1))
        actions = np.where(follows_habit, habit, changing)
        are_alike = rng.random((self.worlds, 1, 1)) < ALIKE
        chosen: np.ndarray = np.where(are_alike, actions[:, :, :1], actions).astype(np.int32)
        return chosen

    def _violations(
        self, worlds: Worlds, played: "Played"
    ) -> tuple[list[tuple[int, np.ndarray]], np.ndarray]:
        """Returns the steps `[B, STEPS]` in which each check is violated, and `triggered`.

        Also those in which a real leaves float32.
        """
        live = ~played.was_over
        live_and_finite = live & played.is_finite.cumprod(axis=1, dtype=bool)
        triggered = worlds.triggered.copy()
        violations = [(FLOATS, live & ~played.is_finite)]
        first = 0
        for i, (number, check) in enumerate(zip(self.numbers, self._checks, strict=True)):
            after = first + len(check.values)
            values = played.values[:, :, first:after]
            first_values = worlds.first_values[:, None, first:after]
            first = after
            match check.kind:
                case "always":
                    is_violated = values[:, :, 0] == 0
                case "conserved":
                    is_violated = ~np.isclose(values, first_values, DRIFT, DRIFT)[:, :, 0]
                case "once":
                    holds = np.logical_or.accumulate(live & (values[:, :, 0] != 0), axis=1)
                    holds |= triggered[:, i, None]
                    if holds.any():
                        self.triggered.add(number)
                    triggered[:, i] = holds[:, -1]
                    is_violated = holds & (values[:, :, 1] == 0)
                case _:
                    states = np.concatenate([first_values, values], axis=1)
                    is_violated = _find_turns(states, rising=check.words[0] == "rising")
            violations.append((number, live_and_finite & is_violated))
        return violations, triggered

    def _scenario(self, worlds: Worlds, segment: int, world: int, steps: int) -> Scenario:
        """Returns what leads the interpreter to a state of a world.

        Args:
          steps: of the latest segment, after which this state comes.
        """
        node = segment * self.worlds + world
        bias: list[Bias] = []  # of each step, the last one first
        actions: list[tuple[int, ...]] = []
        while node >= 0:
            past = self._past[node // self.worlds]
            i = node % self.worlds
            bias += [BIASES[past.bias[i]]] * STEPS
            actions += map(tuple, reversed(past.actions[i].tolist()))
            node = int(past.before[i])
        not_played = STEPS - steps
        return Scenario(
            self.effort.seed,
            int(worlds.episode[world]),
            self._params_sets[worlds.params_set[world]],
            tuple(reversed(bias[not_played:])),
            tuple(reversed(actions[not_played:])),
        )


class Archive:
    """The latest world of each summary, with how often the summary was seen and continued from.

    rows: summary -> the row of its world in `worlds`.
    """

    def __init__(self, most: int) -> None:
        self.rows: dict[int, int] = {}
        self.worlds: Any = None  # Worlds, once some are added
        self._most = most
        self._seen = np.zeros(most)
        self._continued = np.zeros(most)

    def add(self, worlds: Worlds, places: np.ndarray, summary: np.ndarray) -> None:
        """Keeps a world of each summary, of the worlds at these places.

        If there is no room left, they replace those of the summaries that were seen most often.
        """
        # Each summary once, the index among the places of a world that has it, and how many have.
        summaries, indices, times = np.unique(
            summary[places], return_index=True, return_counts=True
        )
        if self.worlds is None:
            self.worlds = jax.tree.map(
                lambda array: np.zeros((self._most, *array.shape[1:]), array.dtype), worlds
            )
        self._make_rows([s for s in summaries.tolist() if s not in self.rows])
        # A summary of these worlds can be among those that made room.
        rows = np.array([self.rows.get(s, -1) for s in summaries.tolist()], int)
        is_kept = rows >= 0
        self._seen[rows[is_kept]] += times[is_kept]
        _put(self.worlds, rows[is_kept], worlds, places[indices[is_kept]])

    def _make_rows(self, summaries: Sequence[int]) -> None:
        """Gives new summaries a row each."""
        free: list[int] = []
        too_many = len(self.rows) + len(summaries) - self._most
        if too_many > 0:
            often_seen_first = sorted(self.rows, key=lambda s: -self._seen[self.rows[s]])
            free = [self.rows.pop(summary) for summary in often_seen_first[:too_many]]
        used = len(self.rows) + len(free)
        free += range(used, len(self.rows) + len(summaries))
        self.rows |= dict(zip(summaries, free, strict=True))
        self._seen[free] = 0
        self._continued[free] = 0

    def choose(self, number: int, rng: np.random.Generator) -> np.ndarray:
        """Returns the rows of worlds to continue, more often those seldom seen and continued."""
        rows = len(self.rows)
        weights = 1 / np.sqrt((1 + self._seen[:rows]) * (1 + self._continued[:rows]))
        chosen = rng.choice(rows, number, p=weights / weights.sum())
        np.add.at(self._continued, chosen, 1)
        return chosen


class Played(NamedTuple):
    """What a segment leads to.

    state, totals: the last ones; is_over `[B]`: whether the episode has ended.
    Of each step: values `[B, STEPS, K]`; was_over `[B, STEPS]`: whether the episode had ended
    before; is_finite `[B, STEPS]`: whether no real is infinite or NaN.
    ran `[B, S]`: whether each statement ran. summary `[B]` uint32: of the last state and of what
    ran.
    """

    state: Any
    totals: dict[str, np.ndarray]
    is_over: np.ndarray
    values: np.ndarray
    was_over: np.ndarray
    is_finite: np.ndarray
    ran: np.ndarray
    summary: np.ndarray


class Program:
    """The compiled game, for worlds side by side."""

    def __init__(self, family: GameFamily, checks: Sequence[ir.Check]):
        self._play = CompiledPlay(family, checks)
        self._game = family.own
        self._num_checks = len(checks)
        self._module = self._play.module
        self.statements = list(self._play.counted.values())
        self.agents = self._play.env.num_agents
        self.length = self._play.env.episode_length
        self._kind_of_place = self._kinds_of_places()
        self._segment = jax.jit(jax.vmap(self._play_segment))
        self._start = jax.jit(jax.vmap(self._play.begin))

    def begin(
        self, params: Sequence[Params], params_set: np.ndarray, episode: np.ndarray, seed: int
    ) -> Worlds:
        """Returns the first states of some episodes, each with its parameters."""
        of_file = self._play.env.params
        changes = [dict(one) for one in params]
        columns = {}
        for param in self._game.params:
            name = param_attribute(param.name)
            default = getattr(of_file, name)
            values = [
                _stored(one[param.name], param.type) if param.name in one else default
                for one in changes
            ]
            columns[name] = np.stack([np.asarray(value, default.dtype) for value in values])
        of_worlds = replace(of_file, **columns)
        state, totals, first_values = jax.tree.map(
            np.array, self._start(of_worlds, episode_keys(seed, episode))
        )
        return Worlds(
            state=state,
            totals=totals,
            params=of_worlds,
            first_values=first_values,
            triggered=np.zeros((len(episode), self._num_checks), np.bool_),
            params_set=params_set,
            episode=episode,
            node=np.full(len(episode), -1),
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

    def _play_segment(
        self,
        state: Any,
        totals: dict[str, Array],
        params: Any,
        key: Array,
        bias: Array,
        actions: Array,
    ) -> tuple[Any, ...]:
        """Returns the parts of `Played` for one world: STEPS steps after a state.

        Once the episode is over, steps go on, but nothing that they do counts.

        Args:
          totals: of the events so far. bias: of the draws of each step.
          actions: `[STEPS, N]` int32.
        """

        def advance(carry: Any, chosen: Array) -> Any:
            """Takes a step, and notes which statements ran in it."""
            *_, was_over = carry
            carry, after = self._play.go_on(carry, params, key, bias, chosen)
            events = [after.events[name] > 0 for name in self._play.counted]
            ran = jnp.array(events, bool) & ~was_over
            return carry, (after.values, was_over, after.is_finite, ran)

        (state, totals, is_over), (values, was_over, is_finite, ran) = jax.lax.scan(
            advance, (state, totals, jnp.bool_(False)), actions
        )
        ran = ran.any(axis=0)
        summary = self._summary(state, values[-1], ran, params)
        return state, totals, is_over, values, was_over, is_finite, ran, summary

    def _summary(self, state: Any, values: Array, ran: Array, params: Any) -> Array:
        """Returns a hash of a state and of the statements that ran, uint32.

        Of the state: its fields, the kinds on which agents and movers stand, what checks read, and
        the part of the episode.
        """
        entity_types = body_types(self._game)
        places = {attribute_of("position", entity_type) for entity_type in entity_types}
        left_out = {"step"}
        for name in ("heading", "moved", "away", "away_pool", "away_facing"):
            left_out |= {attribute_of(name, entity_type) for entity_type in entity_types}
        age = state.step * AGES // jnp.maximum(1, self._module.episode_length(params))
        parts = [age, _clipped(jnp.where(jnp.isfinite(values), values, 0)), ran]
        for name in state.__dataclass_fields__:
            if name not in left_out and not name.startswith("mark_"):
                numbers = getattr(state, name)
                if name in places:
                    numbers = self._kind_of_place[numbers]
                parts.append(_counts(_clipped(numbers)))
        parts = [part.reshape(-1).astype(jnp.int32) for part in parts]
        # Each number times a factor of its own, mixed, and all added up.
        numbers = jnp.concatenate(parts).astype(jnp.uint32)
        factors = np.random.default_rng(0).integers(0, 2**32, numbers.size, np.uint32)
        mixed = (numbers + np.uint32(COUNTED)) * (factors | np.uint32(1))  # odd, to lose no bits
        return jnp.sum((mixed ^ (mixed >> 15)) * np.uint32(0x9E3779B1))

    def _kinds_of_places(self) -> Array:
        """Returns a number for the kind of each cell of the padded map, 0 off the map."""
        module = self._play.env.module
        of_glyph = kinds_by_glyph(self._game)
        names = [kind.name for kind in self._game.kinds]
        numbers = np.zeros(module.FRAME, np.int32)
        for r, row in enumerate(self._game.rows):
            for c, glyph in enumerate(row):
                numbers[r + module.PAD, c + module.PAD] = 1 + names.index(of_glyph[glyph])
        return jnp.asarray(numbers.reshape(-1))


def _stored(value: Any, type_: ir.Type) -> Any:
    """Returns the value of a parameter as a module holds it."""
    if isinstance(value, tuple):
        return [_stored(entry, type_) for entry in value]
    return type_.words.index(value) if type_.kind == "word" else value


def _clipped(numbers: Array) -> Array:
    """Returns the whole part of numbers; beyond COUNTED they are all the same, int32."""
    whole = jnp.floor(numbers) if jnp.issubdtype(numbers.dtype, jnp.floating) else numbers
    return jnp.clip(whole.astype(jnp.int32), -COUNTED, COUNTED)


def _counts(numbers: Array) -> Array:
    """Returns what doesn't depend on the order of numbers.

    Up to COUNTED numbers: these, sorted. More: how often each of -1 .. COUNTED occurs, on a
    logarithmic scale, so that only large differences count.
    """
    flat = numbers.reshape(-1)
    if flat.size <= COUNTED:
        return jnp.sort(flat)
    times = jnp.stack([jnp.sum(flat == number) for number in range(-1, COUNTED + 1)])
    return jnp.floor(2 * jnp.log2(1 + times.astype(jnp.float32))).astype(jnp.int32)


def _put(target: Worlds, places: np.ndarray, source: Worlds, source_places: np.ndarray) -> None:
    """Replaces worlds by others, in place."""
    for old, new in zip(jax.tree.leaves(target), jax.tree.leaves(source), strict=True):
        old[places] = new[source_places]


def _find_turns(pairs: np.ndarray, rising: bool) -> np.ndarray:
    """Returns the steps `[B, STEPS]` whose value went the wrong way since an earlier state.

    Args:
      pairs: `[B, STEPS + 1, 2]`, value and argument of each state of a segment.
      rising: whether the value must grow where the argument does, or else shrink.
    """
    after = pairs[:, 1:, None]
    before = pairs[:, None]
    change = after - before  # [B, STEPS, STEPS + 1, 2]
    product = change[..., 0] * change[..., 1]
    is_wrong = product < 0 if rising else product > 0
    differs = ~np.isclose(after, before, REAL, REAL)
    states = np.arange(pairs.shape[1])
    is_earlier = states[:-1, None] >= states[None]
    return np.asarray((is_wrong & differs.all(axis=-1) & is_earlier).any(axis=2))
