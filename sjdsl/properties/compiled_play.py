"""Plays the compiled game, and reads the values of checks after each step.

It plays single steps with biased draws and counted statements, or whole episodes under policies.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of, event_named
from sjdsl.library.factory import load_module
from sjdsl.policies.compiled import Chooser
from sjdsl.properties.biased_draws import POLICY, RESET, STEP
from sjdsl.properties.compiled_values import lower_checks, with_totals
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import Total
from sjdsl.properties.trajectory import allowed_by, script_of
from sjdsl.runtime.random_bits import below, random_bits_at
from sjdsl.runtime.trials import begin_trial_where, has_trials, is_last_trial, steps_of_trial

BATCH = 10  # episodes played side by side
FAIR = 0  # index of the bias `fair` in BIASES
# Appended to a generated module: its draws take a key with a bias.
BIASED = """
from sjdsl.properties.biased_draws import biased
{names} = {biased}
"""


class Stepped(NamedTuple):
    """What a step leads to.

    totals, events: counts by name, of the episode and of the step; values: what the checks read,
    `[K]` float32; is_finite: whether all reals are numbers.
    """

    state: Any
    totals: dict[str, Array]
    is_over: Array
    values: Array
    is_finite: Array
    events: dict[str, Array]


class CompiledPlay:
    """A compiled game, and the expressions of checks.

    counted: event -> the statement that it counts, for the events that the game got for that.
    totals: event, enum value or None, and the name of its count.
    """

    def __init__(self, family: GameFamily, checks: Sequence[ir.Check]):
        """Raises CompileError for what cannot be compiled exactly, and NotSupported for checks."""
        self.env, self.counted = family.compiled
        self._game: ir.Game = self.env.game
        self.module: Any = _with_bias(self.env.module)
        self.totals = [
            (event.name, *count) for event in self._game.events for count in counts_of(event)
        ]
        self._lowered = lower_checks(self._game, [e for check in checks for e in check.values])

    def begin(self, params: Any, key: Array) -> tuple[Any, dict[str, Array], Array]:
        """Returns the first state of an episode, the totals of events, and the values of checks.

        Args:
          key: of the episode.
        """
        reset_key = jnp.append(derived_key(key, RESET, jnp.int32(0)), jnp.uint32(FAIR))
        state = self.module.reset(params, reset_key)
        totals = {name: jnp.int32(0) for *_, name in self.totals}
        return state, totals, self._values(state, totals, state, totals, params)

    def step(
        self,
        before: Any,
        totals_before: dict[str, Array],
        params: Any,
        key: Array,
        bias: Array,
        actions: Array,
    ) -> Stepped:
        """Takes a step of an episode with this key. bias: its index in BIASES, uint32.

        After the last step of a trial, the state is the first of the next; the values are those
        before.
        """
        length = steps_of_trial(self.module, params)
        number = before.step
        if has_trials(self.module):
            number = number + before.world_trial * length
        step_key = jnp.append(derived_key(key, STEP, number), bias)
        state, out = self.module.step(before, actions, params, step_key)
        state = state.replace(step=state.step + 1)
        events = {}
        for name, attribute, entry in self.module.EVENTS:
            count = getattr(out, attribute)
            events[name] = jnp.sum(count if entry is None else count[..., entry])
        totals = {name: totals_before[name] + events[name] for *_, name in self.totals}
        values = self._values(state, totals, before, totals_before, params)
        is_finite = _is_finite((state, out.reward, values))
        is_over = out.ended | (state.step >= length)
        if has_trials(self.module):
            is_last = is_last_trial(self.module, state)
            begins_trial = is_over & ~is_last
            state = begin_trial_where(self.module, begins_trial, is_last, step_key, params, state)
            is_over &= is_last
        return Stepped(state, totals, is_over, values, is_finite, events)

    def go_on(
        self, carry: tuple[Any, ...], params: Any, key: Array, bias: Array, actions: Array
    ) -> tuple[tuple[Any, ...], Stepped]:
        """Takes a step of an episode, but one that is over stays as it is.

        carry: the state, the totals, and whether the episode is over. Returns them after the step,
        with all that the step leads to.
        """
        before, totals_before, was_over = carry
        after = self.step(before, totals_before, params, key, bias, actions)
        state, totals = jax.tree.map(
            lambda old, new: jnp.where(was_over, old, new),
            (before, totals_before),
            (after.state, after.totals),
        )
        return (state, totals, was_over | after.is_over), after

    def _values(
        self,
        state: Any,
        totals: dict[str, Array],
        before: Any,
        totals_before: dict[str, Array],
        params: Any,
    ) -> Array:
        """Returns what the checks read in a state, `[K]` float32."""
        lowered = self._lowered
        known = _read_totals(lowered.totals, totals, self._game)
        known |= _read_totals(lowered.totals_before, totals_before, self._game)
        values: Array = lowered.values(state, with_totals(params, known), before)
        return values


class Episodes(NamedTuple):
    """B episodes of at most T steps.

    values: `[B, T + 1, K]`, of each expression in the first state and after each step; actions
    `[B, T, N]`; length `[B]`: steps until the end of each.
    overflow `[B]`: the first step in which a real was infinite or NaN, T without one.
    totals: the final ones, `[B]` each.
    """

    values: np.ndarray
    actions: np.ndarray
    length: np.ndarray
    overflow: np.ndarray
    totals: dict[Total, np.ndarray]


class Script(NamedTuple):
    """Policies of all agents as arrays.

    table `[N, A]`: the actions among which each chooses, padded with zeros; entries `[N]`: how
    many. follows `[N]`: the index of the scripted policy that it follows instead, -1 for none.
    """

    table: Array
    entries: Array
    follows: Array


class EpisodePlayer:
    """Plays whole episodes. One compilation serves all policies of its checks."""

    def __init__(self, family: GameFamily, checks: Sequence[ir.Check]):
        self._play = CompiledPlay(family, checks)
        self.env = self._play.env
        scripts = [script_of(policy, family.own) for check in checks for policy in check.policies]
        self._scripts = list(dict.fromkeys(script for script in scripts if script is not None))
        self._choosers: list[Callable[[Any, Array], Array]] = [
            Chooser(self.env, script) for script in self._scripts
        ]
        self._run = jax.jit(jax.vmap(self._episode, in_axes=(0, None)))
        self._step = jax.jit(self._play.step)

    def play(self, policies: Sequence[ir.Policy], seed: int, first: int, number: int) -> Episodes:
        """Plays episodes `first`, `first + 1`, … of a seed: whole batches, at least `number`."""
        script = self._script(policies)
        batches = []
        for start in range(first, first + number, BATCH):
            keys = episode_keys(seed, start + np.arange(BATCH))
            batches.append(jax.tree.map(np.asarray, self._run(keys, script)))
        values, actions, length, overflow, totals = jax.tree.map(
            lambda *parts: np.concatenate(parts), *batches
        )
        totals = {(event, word): totals[name] for event, word, name in self._play.totals}
        return Episodes(values, actions, length, overflow, totals)

    def _script(self, policies: Sequence[ir.Policy]) -> Script:
        """Returns the policies as arrays; agents beyond them begin again with the first."""
        game = self.env.game
        table: list[list[int]] = []
        entries: list[int] = []
        follows: list[int] = []
        for agent in range(self.env.num_agents):
            policy = policies[agent % len(policies)]
            allowed = allowed_by(policy, game)
            table.append([*allowed, *[0] * (self.env.num_actions - len(allowed))])
            entries.append(len(allowed))
            script = script_of(policy, game)
            follows.append(-1 if script is None else self._scripts.index(script))
        return Script(
            jnp.asarray(table, jnp.int32),
            jnp.asarray(entries, jnp.int32),
            jnp.asarray(follows, jnp.int32),
        )

    def state_before(
        self, actions: Sequence[Sequence[int]], seed: int, episode: int, step: int
    ) -> Any:
        """Returns the state before a step of an episode whose actions are known."""
        (key,) = episode_keys(seed, np.array([episode]))
        params = self.env.params
        state, totals, _ = self._play.begin(params, key)
        for chosen in actions[:step]:
            state, totals, *_ = self._step(
                state, totals, params, key, jnp.uint32(FAIR), jnp.asarray(chosen, jnp.int32)
            )
        return state

    def _episode(
        self, key: Array, script: Script
    ) -> tuple[Array, Array, Array, Array, dict[str, Array]]:
        """Returns the values, actions, length, overflow and totals of one episode."""
        params = self.env.params
        steps = self.env.episode_length

        def advance(carry: Any, t: Array) -> Any:
            """Takes a step under the policies."""
            before, _, was_over = carry
            actions = self._choose(before, derived_key(key, POLICY, t), script)
            carry, after = self._play.go_on(carry, params, key, jnp.uint32(FAIR), actions)
            return carry, (after.values, actions, was_over, was_over | after.is_finite)

        state, totals, first_values = self._play.begin(params, key)
        (_, totals, _), (values, actions, was_over, is_finite) = jax.lax.scan(
            advance, (state, totals, jnp.bool_(False)), jnp.arange(steps)
        )
        values = jnp.concatenate([first_values[None], values])
        overflow = jnp.where(is_finite, steps, jnp.arange(steps)).min()
        return values, actions, jnp.sum(~was_over), overflow, totals

    def _choose(self, state: Any, key: Array, script: Script) -> Array:
        """Returns an action for each agent, as `trajectory.choose` does on the interpreter."""
        agents = self.env.num_agents
        bits = random_bits_at(key, 0, jnp.arange(2 * agents, dtype=jnp.uint32)).reshape(agents, 2)
        entry = below(bits[:, 0], script.entries)
        actions = jnp.take_along_axis(script.table, entry[:, None], axis=1)[:, 0]
        for number, chooser in enumerate(self._choosers):
            follows = script.follows == number
            # The script is the same in all episodes, so `cond` skips policies nobody follows.
            chosen = jax.lax.cond(
                jnp.any(follows), chooser, lambda *_: jnp.zeros(agents, jnp.int32), state, bits
            )
            actions = jnp.where(follows, chosen, actions)
        return actions


def episode_keys(seed: int, episode: np.ndarray) -> Array:
    """Returns the keys of episodes, from which all their draws come, `[B, 2]` uint32."""
    seeds = np.full(len(episode), seed & 0xFFFFFFFF)
    return jnp.asarray(np.stack([seeds, episode], axis=1).astype(np.uint32))


def derived_key(key: Array, stream: int, number: Array) -> Array:
    """Returns the key that another gives for a number of one of its streams, `[2]` uint32."""
    first = 2 * number.astype(jnp.uint32)
    return random_bits_at(key, stream, first + jnp.arange(2, dtype=jnp.uint32))


def _with_bias(module: Any) -> Any:
    """Returns a generated module whose keys have a third number, an index of BIASES."""
    _, (text, file, name) = module.__reduce__()  # a generated module is copied by its text
    draws = [draw for draw in ("random_bits", "random_bits_at") if hasattr(module, draw)]
    if draws:
        text += BIASED.format(
            names=", ".join(draws), biased=", ".join(f"biased({draw})" for draw in draws)
        )
    return load_module(text, f"{file}, with biased draws", name)


def _is_finite(tree: Any) -> Array:
    """Returns whether no real of a tree is infinite or NaN."""
    are_finite = [
        jnp.all(jnp.isfinite(leaf))
        for leaf in jax.tree.leaves(tree)
        if jnp.issubdtype(leaf.dtype, jnp.floating)
    ]
    return jnp.all(jnp.stack(are_finite)) if are_finite else jnp.bool_(True)


def _read_totals(
    attributes: Mapping[Total, str], totals: Mapping[str, Array], game: ir.Game
) -> dict[str, Array]:
    """Returns totals by the attributes under which the expressions read them.

    The total of an event that is read without one of its enum values is the sum over all of them.
    """
    values = {}
    for (name, word), attribute in attributes.items():
        counts = [
            totals[count]
            for counted, count in counts_of(event_named(game, name))
            if word in (None, counted)
        ]
        values[attribute] = sum(counts, jnp.int32(0))
    return values
