"""Plays the compiled game step by step with its draws biased and its statements counted, and whole episodes under scripted policies.

After each step it reads the values of checks.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.library.factory import load_module
from sjdsl.policies.compiled import Chooser
from sjdsl.properties.biased_draws import POLICY, RESET, STEP
from sjdsl.properties.compiled_values import Total, lower_checks, with_totals
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.trajectory import allowed_by, script_of
from sjdsl.runtime.random_bits import below, random_bits_at
from sjdsl.runtime.trials import begin_trial_where, has_trials, is_last_trial, steps_of_trial

BATCH = 10  # episodes played side by side
FAIR = 0  # no bias of the draws
BIASED = """
from sjdsl.properties.biased_draws import biased
{names} = {biased}
"""


class Stepped(NamedTuple):
    """What a step leads to. values: what the checks read then, float32 `[K]`; finite: whether all reals are numbers; events: counts by name."""

    state: Any
    totals: dict[str, Array]
    over: Array
    values: Array
    finite: Array
    events: dict[str, Array]


class CompiledPlay:
    """A compiled game, and the expressions of checks. counted: the statement that each of its additional events counts, by name."""

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
        """Returns the first state of an episode with its own key, the totals of events, and the values of checks."""
        state = self.module.reset(
            params, jnp.append(derived_key(key, RESET, jnp.int32(0)), jnp.uint32(FAIR))
        )
        totals = {name: jnp.int32(0) for *_, name in self.totals}
        return state, totals, self._values(state, totals, state, totals, params)

    def step(
        self,
        before: Any,
        earlier: dict[str, Array],
        params: Any,
        key: Array,
        bias: Array,
        actions: Array,
    ) -> Stepped:
        """Takes a step of an episode. bias: its place in BIASES, uint32.

        After the last step of a trial, the state is the first of the next; the values are those
        before.
        """
        length = steps_of_trial(self.module, params)
        number = before.step
        if has_trials(self.module):
            number = number + before.world_trial * length
        words = jnp.append(derived_key(key, STEP, number), bias)
        state, out = self.module.step(before, actions, params, words)
        state = state.replace(step=state.step + 1)
        counts = (
            (name, getattr(out, attribute), entry) for name, attribute, entry in self.module.EVENTS
        )
        events = {
            name: jnp.sum(count if entry is None else count[..., entry])
            for name, count, entry in counts
        }
        totals = {name: earlier[name] + events[name] for *_, name in self.totals}
        values = self._values(state, totals, before, earlier, params)
        finite = _is_finite((state, out.reward, values))
        over = out.ended | (state.step >= length)
        if has_trials(self.module):
            is_last = is_last_trial(self.module, state)
            state = begin_trial_where(self.module, over & ~is_last, is_last, words, params, state)
            over &= is_last
        return Stepped(state, totals, over, values, finite, events)

    def _values(self, state: Any, totals: Any, before: Any, earlier: Any, params: Any) -> Array:
        lowered = self._lowered
        known = _read_totals(lowered.totals, totals, self._game) | _read_totals(
            lowered.earlier, earlier, self._game
        )
        found: Array = lowered.values(state, with_totals(params, known), before)
        return found


class Episodes(NamedTuple):
    """B episodes.

    values: `[B, T + 1, K]`, of each expression in the first state and after each step; actions `[B, T, N]`; length `[B]`, steps until the end
    of each; left `[B]`: the first step in which a real was infinite or no number, T if none was. totals: the final ones, by event and word.
    """

    values: np.ndarray
    actions: np.ndarray
    length: np.ndarray
    left: np.ndarray
    totals: dict[Total, np.ndarray]


class Script(NamedTuple):
    """Policies of all agents as arrays.

    table: the actions that each draws from; entries: how many. follows: which of the scripts it follows; -1: none.
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
        """Plays episodes `first`, `first + 1`, … of a seed; at least `number` of them, in whole batches."""
        game = self.env.game
        mine = [policies[agent % len(policies)] for agent in range(self.env.num_agents)]
        allowed = [allowed_by(policy, game) for policy in mine]
        table = [[*actions, *[0] * (self.env.num_actions - len(actions))] for actions in allowed]
        follows = [
            -1 if (one := script_of(policy, game)) is None else self._scripts.index(one)
            for policy in mine
        ]
        script = Script(
            *(
                jnp.asarray(x, jnp.int32)
                for x in (table, [len(actions) for actions in allowed], follows)
            )
        )
        parts = [
            jax.tree.map(
                np.asarray, self._run(episode_keys(seed, start + np.arange(BATCH)), script)
            )
            for start in range(first, first + number, BATCH)
        ]
        values, actions, length, left, totals = jax.tree.map(lambda *x: np.concatenate(x), *parts)
        return Episodes(
            values,
            actions,
            length,
            left,
            {(event, word): totals[name] for event, word, name in self._play.totals},
        )

    def state_before(
        self, actions: Sequence[Sequence[int]], seed: int, episode: int, step: int
    ) -> Any:
        """Returns the state before a step of an episode whose actions are known."""
        (key,) = episode_keys(seed, np.array([episode]))
        state, totals, _ = self._play.begin(self.env.params, key)
        for t in range(step):
            state, totals, *_ = self._step(
                state,
                totals,
                self.env.params,
                key,
                jnp.uint32(FAIR),
                jnp.asarray(actions[t], jnp.int32),
            )
        return state

    def _episode(
        self, key: Array, script: Script
    ) -> tuple[Array, Array, Array, Array, dict[str, Array]]:
        params, steps = self.env.params, self.env.episode_length

        def advance(carry: Any, t: Array) -> Any:
            before, earlier, over = carry
            actions = self._choose(before, derived_key(key, POLICY, t), script)
            after = self._play.step(before, earlier, params, key, jnp.uint32(FAIR), actions)
            state, totals = jax.tree.map(
                lambda old, new: jnp.where(over, old, new),
                (before, earlier),
                (after.state, after.totals),
            )
            return (state, totals, over | after.over), (
                after.values,
                actions,
                over,
                over | after.finite,
            )

        state, totals, first = self._play.begin(params, key)
        carry, (values, actions, over, finite) = jax.lax.scan(
            advance, (state, totals, jnp.bool_(False)), jnp.arange(steps)
        )
        left = jnp.where(finite, steps, jnp.arange(steps)).min()
        return jnp.concatenate([first[None], values]), actions, jnp.sum(~over), left, carry[1]

    def _choose(self, state: Any, key: Array, script: Script) -> Array:
        """Returns an action for each agent, as `trajectory.choose` does on the interpreter."""
        agents = self.env.num_agents
        bits = random_bits_at(key, 0, jnp.arange(2 * agents, dtype=jnp.uint32)).reshape(agents, 2)
        actions = jnp.take_along_axis(
            script.table, below(bits[:, 0], script.entries)[:, None], axis=1
        )[:, 0]
        for i, chooser in enumerate(
            self._choosers
        ):  # the script is the same in all episodes: those that nobody follows cost nothing
            follows = script.follows == i
            chosen = jax.lax.cond(
                jnp.any(follows), chooser, lambda *_: jnp.zeros(agents, jnp.int32), state, bits
            )
            actions = jnp.where(follows, chosen, actions)
        return actions


def episode_keys(seed: int, episode: np.ndarray) -> Array:
    """Returns the keys of episodes, from which all their draws come, uint32 `[B, 2]`."""
    return jnp.asarray(
        np.stack([np.full(len(episode), seed & 0xFFFFFFFF), episode], 1).astype(np.uint32)
    )


def derived_key(key: Array, stream: int, number: Array) -> Array:
    """Returns the two numbers of a key made from another."""
    return random_bits_at(
        key, stream, 2 * number.astype(jnp.uint32) + jnp.arange(2, dtype=jnp.uint32)
    )


def _with_bias(module: Any) -> Any:
    """Returns a generated module in which a key has a third word, the bias of the draws, by its place in BIASES."""
    _, (text, file, name) = module.__reduce__()
    names = [n for n in ("random_bits", "random_bits_at") if hasattr(module, n)]
    more = (
        BIASED.format(names=", ".join(names), biased=", ".join(f"biased({n})" for n in names))
        if names
        else ""
    )
    return load_module(text + more, f"{file}, with biased draws", name)


def _is_finite(tree: Any) -> Array:
    """Returns whether all reals of a tree are numbers inside float32."""
    reals = [leaf for leaf in jax.tree.leaves(tree) if jnp.issubdtype(leaf.dtype, jnp.floating)]
    return (
        jnp.all(jnp.stack([jnp.all(jnp.isfinite(leaf)) for leaf in reals]))
        if reals
        else jnp.bool_(True)
    )


def _read_totals(
    names: Mapping[Total, str], totals: dict[str, Array], game: ir.Game
) -> dict[str, Array]:
    """Returns what the expressions call the totals; the total of an event by words, if no word is given, is the sum over its words."""
    words = {e.name: () if e.by is None else e.by.keys for e in game.events}
    found = {}
    for (event, word), attribute in names.items():
        every = (word,) if word else words[event] or (None,)
        found[attribute] = sum(
            (totals[f"{event}[{w}]" if w else event] for w in every), jnp.int32(0)
        )
    return found
