"""An episode of a program twice side by side: from its own start with its own numbers, and crowded and busy.

In the busy run agents begin side by side where something can happen, act more than they walk, and what is rare comes often.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.library.parameters import build_params
from sjdsl.runtime.env import Environment

from .environments import Cell, environment, frame_cells
from .found import Form

QUICK = {
    "xla_backend_optimization_level": 0,
    "xla_llvm_disable_expensive_passes": True,
}  # compiling costs more than running
AFTER = 10  # steps of the next episode
OFTEN = 0.3  # chance of what is rarer by itself, in the busy run


@dataclass(frozen=True)
class Play:
    """Two runs, the own one and the busy one, of T steps."""

    env: Environment
    params: Any  # [2, ...]
    reset_words: np.ndarray  # [2] uint32, the key of the own start
    reset_observation: np.ndarray
    starts: Any  # [2, ...] states
    words: np.ndarray  # [T, 2] uint32, the keys of the steps
    actions: np.ndarray  # [2, T, N]; some are no actions
    states: Any  # [2, T, ...] after each step; after an episode's last step the start of the next
    observations: np.ndarray  # [2, T, N, rows, columns, planes] of these states
    rewards: np.ndarray  # [2, T, N]
    dones: np.ndarray  # [2, T]
    infos: dict[str, Any]  # [2, T, ...] truncated, terminated, events, metrics
    terminal: np.ndarray  # [2, N, rows, columns, planes] observation of the first episode's end

    def ends(self) -> list[int]:
        """Returns the number of the step that ends the first episode, in either run."""
        return [int(np.flatnonzero(dones)[0]) for dones in self.dones]

    def state(self, run: int, step: int) -> Any:
        """Returns the state after so many steps of a run."""
        return jax.tree.map(
            lambda x: x[run] if step == 0 else x[run, step - 1],
            self.starts if step == 0 else self.states,
        )


@lru_cache(maxsize=1)
def played(form: Form) -> Play:
    """Returns the two runs of a form; the last one asked for is kept."""
    env, random = environment(*form), np.random.default_rng(0)
    steps = env.episode_length + AFTER
    words = random.integers(0, 2**32, (steps + 1, 2), np.uint32)
    reset_observation, start = jax.jit(env.reset, compiler_options=QUICK)(
        jax.random.wrap_key_data(words[-1])
    )
    starts = jax.tree.map(lambda *x: jnp.stack(x), start, crowded(env, start, random))
    params = jax.tree.map(lambda *x: jnp.stack(x), env.params, busy_params(env))
    actions = np.stack(
        [random_actions(env, random, (steps, env.num_agents), own) for own in (1, 3)]
    )
    run = jax.jit(jax.vmap(episode_of(env), in_axes=(0, None, 0, 0)), compiler_options=QUICK)
    history, terminal = jax.tree.map(
        np.asarray, run(starts, jax.random.wrap_key_data(words[:-1]), actions, params)
    )
    starts = jax.tree.map(np.asarray, starts)
    return Play(
        env,
        params,
        words[-1],
        np.asarray(reset_observation),
        starts,
        words[:-1],
        actions,
        *history,
        terminal,
    )


def episode_of(env: Environment) -> Any:
    """Returns a function from a start, keys, actions and params to all steps and the terminal observation."""

    def run(start: Any, keys: jax.Array, actions: jax.Array, params: Any) -> Any:
        def advance(carry: Any, given: Any) -> Any:
            state, terminal = carry
            key, chosen = given
            observation, state, reward, done, info = env.step(key, state, chosen, params)
            terminal = jnp.where(done, info["terminal_observation"], terminal)
            told = {name: info[name] for name in ("truncated", "terminated", "events", "metrics")}
            return (state, terminal), (state, observation, reward, done, told)

        nothing = jnp.zeros(env.observation_shape, env.observation_dtype)
        (_, terminal), history = jax.lax.scan(advance, (start, nothing), (keys, actions))
        return history, terminal

    return run


def random_actions(
    env: Environment, random: np.random.Generator, shape: tuple[int, ...], own: float
) -> np.ndarray:
    """Returns random actions, one number too many on each side; the game's own ones `own` times as often as walking."""
    walking = {"turn_left", "turn_right", "step_left", "step_right", "forward", "backward", "stay"}
    weights = np.array([0.3, *(1.0 if name in walking else own for name in env.action_names), 0.3])
    return random.choice(
        np.arange(-1, env.num_actions + 1), shape, p=weights / weights.sum()
    ).astype(np.int32)


def crowded(env: Environment, start: Any, random: np.random.Generator) -> Any:
    """Returns a start with the agents on the cells nearest to one in the middle of those that have fields."""
    kind_of = {
        g.glyph: next(k for k in env.game.kinds if k.name == g.kind) for g in env.game.glyphs
    }
    cells: dict[Cell, Any] = {
        (r, c): kind_of[glyph] for r, row in enumerate(env.game.rows) for c, glyph in enumerate(row)
    }
    open_cells = [
        cell
        for cell, kind in cells.items()
        if not any(block.what == "agents" for block in kind.blocks)
    ]
    alive = [cell for cell in open_cells if cells[cell].fields] or open_cells
    row, col = alive[len(alive) // 2]
    near = sorted(open_cells, key=lambda cell: abs(cell[0] - row) + abs(cell[1] - col))[
        : env.num_agents
    ]
    heading = jnp.asarray(random.integers(0, 4, env.num_agents), jnp.int32)
    return start.replace(
        position=jnp.asarray(frame_cells(env, random.permutation(near))), heading=heading
    )


def busy_params(env: Environment) -> Any:
    """Returns the parameters with every chance raised, if the `require`s of the game allow it."""

    def raised(value: Any, high: float) -> Any:
        return (
            [raised(entry, high) for entry in value]
            if isinstance(value, tuple)
            else min(max(value, OFTEN), high)
        )

    chances = {
        p.name: raised(p.value, p.type.high)
        for p in env.game.params
        if p.type.unit == "probability"
    }
    try:
        return build_params(env.game, env.module, chances)
    except ValueError:
        return env.params
