"""Plays whole episodes of the compiled game under scripted policies, and reads the values of its checks after every step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.policies.compiled import Chooser
from sjdsl.properties.biased_draws import POLICY, RESET, STEP
from sjdsl.properties.compiled_values import Total, lower_checks, with_totals
from sjdsl.properties.scripted_policies import FAR, WANDERS, ShortestPaths, allowed_by, policy_named, shortest_paths_of
from sjdsl.runtime.env import Environment
from sjdsl.runtime.random_bits import below, random_bits_at

BATCH = 10  # episodes played side by side


@dataclass(frozen=True)
class Episodes:
    """B episodes.

    values: `[B, T + 1, K]`, of each expression in the first state and after each step; actions `[B, T, N]`; length `[B]`, steps
    until the end of each; totals: the final ones, (event, word or None) -> `[B]`. number: that of the first episode. left `[B]`: the first
    step in which a real of the state, a reward or a value was infinite or no number; T if none was.
    """

    number: int
    values: np.ndarray
    actions: np.ndarray
    length: np.ndarray
    totals: dict[tuple[str, str | None], np.ndarray]
    left: np.ndarray


class Script(NamedTuple):
    """Policies of all agents as arrays.

    table: the actions that each draws from; entries: how many. seek, scripted: which `seek`, which policy of the file it follows; -1: none.
    """

    table: Array
    entries: Array
    seek: Array
    scripted: Array


class Player:
    """Plays a compiled game. One compilation serves all policies of its checks."""

    def __init__(self, env: Environment, checks: Sequence[ir.Check]):
        self.env = env
        self.expressions = [e for check in checks for e in check.values]
        self.domains = list(dict.fromkeys(p.domain for check in checks for p in check.policies if p.domain is not None))
        self.scripted = list(dict.fromkeys(p.scripted for check in checks for p in check.policies if p.scripted))
        self._choosers = [Chooser(env, policy_named(env.game, name)) for name in self.scripted]
        self._lowered = lower_checks(env.game, self.expressions, self.domains)
        self._shortest_paths = shortest_paths_of(env.game) if self.domains else None
        self._steps = env.episode_length
        self._run = jax.jit(jax.vmap(self._episode, in_axes=(0, None)))
        self._step = jax.jit(env.step_env)

    def script(self, policies: Sequence[ir.Policy]) -> Script:
        """Returns policies for all agents, in turn."""
        game = self.env.game
        mine = [policies[agent % len(policies)] for agent in range(self.env.num_agents)]
        allowed = [allowed_by(policy, game) for policy in mine]
        table = [[*actions, *[0] * (self.env.num_actions - len(actions))] for actions in allowed]
        seek = [-1 if p.domain is None else self.domains.index(p.domain) for p in mine]
        scripted = [self.scripted.index(p.scripted) if p.scripted else -1 for p in mine]
        return Script(*(jnp.asarray(x, jnp.int32) for x in (table, [len(actions) for actions in allowed], seek, scripted)))

    def play(self, script: Script, seed: int, first: int, number: int) -> Episodes:
        """Plays episodes `first`, `first + 1`, … of a seed; at least `number` of them, in whole batches."""
        parts = []
        for start in range(first, first + number, BATCH):
            keys = np.array([(seed & 0xFFFFFFFF, start + i) for i in range(BATCH)], np.uint32)
            arguments = (jnp.asarray(keys), script)
            parts.append(jax.tree.map(np.asarray, self._run(*arguments)))
        values, actions, length, totals, left = (jax.tree.map(lambda *x: np.concatenate(x), *[p[i] for p in parts]) for i in range(5))
        return Episodes(first, values, actions, length, totals, left)

    def state_before(self, actions: np.ndarray, seed: int, episode: int, step: int) -> Any:
        """Returns the state before a step of an episode whose actions are known."""
        key = jnp.asarray(np.array([seed & 0xFFFFFFFF, episode], np.uint32))
        _, state = self.env.reset(derived_key(key, RESET, jnp.int32(0)))
        for t in range(step):
            _, state, *_ = self._step(derived_key(key, STEP, jnp.int32(t)), state, jnp.asarray(actions[t]))
        return state

    def _episode(self, key: Array, script: Script) -> Any:
        env, lowered = self.env, self._lowered
        names = [(event.name, *count) for event in env.game.events for count in counts_of(event)]

        def read(state: Any, totals: dict[str, Array], before: Any, earlier: dict[str, Array]) -> Any:
            known = read_totals(lowered.totals, totals, env.game) | read_totals(lowered.earlier, earlier, env.game)
            return lowered.values(state, with_totals(env.params, known), before)

        def advance(carry: Any, t: Array) -> Any:
            before, totals, over = carry
            actions = self._choose(before, derived_key(key, POLICY, t), script)
            _, state, reward, done, info = env.step_env(derived_key(key, STEP, t), before, actions)
            counted = {name: totals[name] + jnp.where(over, 0, jnp.sum(info["events"][name])) for *_, name in names}
            values = read(state, counted, before, totals)
            return (state, counted, over | done), (values, actions, over, is_finite((state, reward, values)))

        _, state = env.reset(derived_key(key, RESET, jnp.int32(0)))
        none = {name: jnp.int32(0) for *_, name in names}
        first = read(state, none, state, none)
        (_, totals, _), (values, actions, over, finite) = jax.lax.scan(advance, (state, none, jnp.bool_(False)), jnp.arange(self._steps))
        length = jnp.sum(~over)
        left = jnp.where(finite, self._steps, jnp.arange(self._steps)).min()
        return jnp.concatenate([first[None], values]), actions, length, {(e, w): totals[name] for e, w, name in names}, left

    def _choose(self, state: Any, key: Array, script: Script) -> Array:
        """Returns an action for each agent, as `scripted_policies.choose` does on the interpreter."""
        agents = self.env.num_agents
        bits = random_bits_at(key, 0, jnp.arange(2 * agents, dtype=jnp.uint32)).reshape(agents, 2)
        actions = jnp.take_along_axis(script.table, below(bits[:, 0], script.entries)[:, None], axis=1)[:, 0]
        for i, chooser in enumerate(self._choosers):  # the script is the same in all episodes: those that nobody follows cost nothing
            follows = script.scripted == i
            chosen = jax.lax.cond(jnp.any(follows), chooser, lambda *_: jnp.zeros(agents, jnp.int32), state, bits)
            actions = jnp.where(follows, chosen, actions)
        if self._shortest_paths is None:
            return actions
        wandering = below(bits[:, 1], jnp.int32(WANDERS)) == 0
        for i, where in enumerate(self._lowered.seeks):
            cells, members = where(state, self.env.params)
            walks = self._walk(state, cells, members & ~wandering[:, None], bits[:, 0], self._shortest_paths)
            actions = jnp.where(script.seek == i, walks, actions)
        return actions

    def _walk(self, state: Any, cells: Array, members: Array, bits: Array, paths: ShortestPaths) -> Array:
        stay = jnp.int32(self.env.game.agents.actions.index("stay"))
        if not paths.moves:
            return jnp.full(self.env.num_agents, stay)
        row, col = self.env.cells(state)
        away = state.position == 0
        node = jnp.where(away, 0, (row * paths.width + col) * 4 + state.heading)
        columns = 1 if paths.headed else 4
        distance, after, moves = jnp.asarray(paths.distance), jnp.asarray(paths.after), jnp.asarray(paths.moves, jnp.int32)
        cells = jnp.where(members, cells, 0)
        away_by = jnp.where(members, distance[cells, (node // columns)[:, None]], FAR)
        nearest = jnp.argmin(away_by, axis=1)[:, None]
        least = jnp.take_along_axis(away_by, nearest, axis=1)[:, 0]
        target = jnp.take_along_axis(cells, nearest, axis=1)
        best = moves[jnp.argmin(distance[target, after[node] // columns], axis=1)]
        lost = moves[below(bits, jnp.int32(len(paths.moves)))]
        return jnp.where(away | (least == 0), stay, jnp.where(least == FAR, lost, best))


def is_finite(tree: Any) -> Array:
    """Returns whether all reals of a tree are numbers inside float32."""
    reals = [leaf for leaf in jax.tree.leaves(tree) if jnp.issubdtype(leaf.dtype, jnp.floating)]
    return jnp.all(jnp.stack([jnp.all(jnp.isfinite(leaf)) for leaf in reals])) if reals else jnp.bool_(True)


def read_totals(names: Mapping[Total, str], totals: dict[str, Array], game: ir.Game) -> dict[str, Array]:
    """Returns what the expressions call the totals; the total of an event by words, if no word is given, is the sum over its words."""
    words = {e.name: () if e.by is None else e.by.keys for e in game.events}
    found = {}
    for (event, word), attribute in names.items():
        every = (word,) if word else words[event] or (None,)
        found[attribute] = sum((totals[f"{event}[{w}]" if w else event] for w in every), jnp.int32(0))
    return found


def derived_key(key: Array, stream: int, number: Array) -> Array:
    """Returns the two numbers of a key made from another."""
    return random_bits_at(key, stream, 2 * number.astype(jnp.uint32) + jnp.arange(2, dtype=jnp.uint32))
