"""Scripted policies as JAX functions of the true state: the first rule that applies to an agent is the one it follows."""

from collections.abc import Iterator
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import blocks_always, body_sorts, kinds_by_glyph, shape_named
from sjdsl.policies.declared import declared_policies
from sjdsl.policies.lowering import Cells, LoweredRule, lower_policy
from sjdsl.runtime.env import Environment
from sjdsl.runtime.geometry import turned
from sjdsl.runtime.path_search import (
    board,
    contains,
    destination,
    first_moves,
    moves_of,
    shifted,
    wrapped,
)
from sjdsl.runtime.policy import MemoryPolicy
from sjdsl.runtime.random_bits import below, key_words, random_bits_at

HALF = 1 << 31  # a 32-bit number is below it with probability one half


def scripted_policy(env: Any, name: str) -> MemoryPolicy:
    """Returns a policy that the game's file declares.

    It reads the state, not the observation, and needs no memory. One compilation serves all agents.

    Args:
      env: a `sjdsl.Environment`, or what passes its attributes on.
    Raises:
      KeyError: the game has no policy of that name. NotSupported: the compiler cannot say exactly what it reads.
    """
    choose = Chooser(env, declared_policies(env)[name])

    def act(memory: Any, key: Array, observation: Array, state: Any) -> tuple[Any, Array]:
        del observation
        bits = random_bits_at(
            key_words(key), 0, jnp.arange(2 * env.num_agents, dtype=jnp.uint32)
        ).reshape(env.num_agents, 2)
        return memory, choose(state, bits)

    return MemoryPolicy((), act, reads_state=True)


class Chooser:
    """What the agents of one policy do in a state."""

    def __init__(self, env: Environment, policy: ir.ScriptedPolicy):
        """Raises NotSupported."""
        self._env = env
        self._game: ir.Game = env.game
        self._rules, self._pad = lower_policy(policy, self._game)
        self._stay = self._game.agents.actions.index("stay")
        self._moves = moves_of(
            self._game.agents.actions,
            self._game.agents.relative,
            open_cells(self._game),
            self._game.wraps,
        )
        self._shape = self._moves.open.shape

    def __call__(self, state: Any, bits: Array) -> Array:
        """Returns an action for each agent, `[N]` int32.

        Args:
          bits: `[N, 2]` uint32, two random numbers for each agent.
        """
        row, col = self._env.cells(state)
        here = (state.heading, row, col)
        present = state.position != 0
        read = self._reframed(state)
        actions = jnp.full(self._env.num_agents, self._stay, jnp.int32)
        undecided = present
        for rule in self._rules:
            applies, chosen = self._follow(rule, read, here, present, undecided, bits)
            actions = jnp.where(undecided & applies, chosen, actions)
            undecided = undecided & ~applies
        return actions

    def _follow(
        self,
        lowered: LoweredRule,
        state: Any,
        here: tuple[Array, Array, Array],
        present: Array,
        wanted: Array,
        bits: Array,
    ) -> tuple[Array, Array]:
        """Returns to which agents a rule applies, `[N]` bool, and what they do by it, `[N]` int32."""
        rule, params = lowered.rule, self._env.params
        if isinstance(rule, ir.Act):
            assert lowered.condition is not None
            return lowered.condition(state, params), self._taken(lowered, state)
        if lowered.sought is None:
            return jnp.zeros_like(wanted), jnp.zeros_like(here[0])
        members = self._board(lowered.sought, state)
        enterable = board(jnp.asarray(self._moves.open))[None]
        if lowered.avoided is not None:
            closed = self._board(lowered.avoided, state)
            enterable = enterable & (~closed | members if isinstance(rule, ir.Go) else ~closed)
        if isinstance(rule, ir.Go):
            turns = 4 if self._moves.turns_matter else 1
            goals, done = jnp.repeat(members[:, None], turns, axis=1), jnp.int32(self._stay)
        else:
            goals, done = self._poses(rule, members), self._taken(lowered, state)
        if not self._moves.actions:  # nobody walks: a rule applies to those who are there already
            return self._is_there(goals, here), jnp.broadcast_to(done, here[0].shape)
        arrived, found, best = first_moves(self._moves, goals, enterable, here, wanted)
        return found, jnp.where(
            arrived, done, self._walk(best, enterable, here, present, self._movers(state), bits)
        )

    def _is_there(self, goals: Array, here: tuple[Array, Array, Array]) -> Array:
        """Returns which agents are where a rule leads, `[N]` bool. goals: `[K, P, H, L]` boards."""
        heading, row, col = here
        agents = jnp.arange(row.shape[0])
        own = goals[
            agents if goals.shape[0] > 1 else 0,
            heading if goals.shape[1] > 1 else jnp.zeros_like(heading),
        ]
        return contains(own, agents[:, None], row[:, None], col[:, None])[:, 0]

    def _taken(self, lowered: LoweredRule, state: Any) -> Array:
        """Returns the action that each agent ends in by a rule, `[N]` int32."""
        assert not isinstance(lowered.rule, ir.Go)
        if lowered.taken is None:
            return jnp.full(self._env.num_agents, lowered.rule.action, jnp.int32)
        taken: Array = lowered.taken(state, self._env.params)
        return taken

    def _movers(self, state: Any) -> list[Array]:
        """Returns where the movers of each sort are, `row * width + column` of the map, -1 for those that are away."""
        cols, width = self._shape[1] + 2 * self._pad, self._shape[1]
        positions = [
            getattr(state, attribute_of("position", sort.sort)) for sort in self._game.movers
        ]
        return [
            jnp.where(at == 0, -1, (at // cols - self._pad) * width + at % cols - self._pad)
            for at in positions
        ]

    def _walk(
        self,
        best: Array,
        enterable: Array,
        here: tuple[Array, Array, Array],
        present: Array,
        movers: list[Array],
        bits: Array,
    ) -> Array:
        """Returns the moves; where another agent or a mover is in the way, half of them are drawn from those that enter nothing avoided."""
        heading, row, col = here
        places = [
            (row, col) if step is None else destination(self._moves, step, heading, row, col)
            for step in self._moves.steps
        ]
        rows, cols = (jnp.stack([place[axis] for place in places], axis=-1) for axis in (0, 1))
        which = (
            jnp.arange(rows.shape[0])
            if enterable.shape[0] > 1
            else jnp.zeros(rows.shape[0], jnp.int32)
        )
        may = contains(enterable, jnp.broadcast_to(which[:, None], rows.shape), rows, cols)
        may = may | ((rows == row[:, None]) & (cols == col[:, None]))
        to_row, to_col = (jnp.take_along_axis(x, best[:, None], axis=1) for x in (rows, cols))
        others = present[None] & ~jnp.eye(row.shape[0], dtype=bool)
        blocked = jnp.any((to_row == row[None]) & (to_col == col[None]) & others, axis=1)
        for at in movers:
            blocked = blocked | jnp.any((to_row * self._shape[1] + to_col) == at[None], axis=1)
        drawn = jnp.argmax(
            jnp.cumsum(may, axis=1) > below(bits[:, 0], jnp.sum(may, axis=1))[:, None], axis=1
        )
        move = jnp.where(blocked & (bits[:, 1] < jnp.uint32(HALF)), drawn.astype(jnp.int32), best)
        return jnp.asarray(self._moves.actions, jnp.int32)[move]

    def _board(self, cells: Cells, state: Any) -> Array:
        """Returns the cells of members as boards, `[N or 1, H, L]`."""
        height, width = self._shape
        if cells.numbers is not None:
            members = cells.read(state, self._env.params)
            padded = jnp.concatenate([members, jnp.zeros((members.shape[0], 1), bool)], axis=1)
            return board(padded[:, jnp.asarray(cells.numbers)].reshape(-1, height, width))
        members, at = cells.read(state, self._env.params)
        row = jnp.arange(members.shape[0])[:, None]
        full = (
            jnp.zeros((members.shape[0], height * width), bool)
            .at[row, jnp.where(members, at, height * width)]
            .set(True, mode="drop")
        )
        return board(full.reshape(-1, height, width))

    def _poses(self, rule: ir.Aim, members: Array) -> Array:
        """Returns where, and with which heading, an agent has a member in the shape: `[K, P, H, L]` boards."""
        game = self._game
        shape = shape_named(
            game.model_copy(update={"shapes": (*game.shapes, *game.policy_shapes)}), rule.shape
        )
        moved = wrapped if game.wraps else shifted
        planes = 4 if shape.directed or self._moves.turns_matter else 1
        found = []
        for heading in range(planes):
            poses = jnp.zeros_like(members)
            for (rows, cols), seen in visible_from(game, shape, heading):
                poses = poses | (
                    moved(members, -rows, -cols, self._shape[1]) & board(jnp.asarray(seen))[None]
                )
            found.append(poses)
        return jnp.stack(found, axis=1)

    def _reframed(self, state: Any) -> Any:
        """Returns the state with positions in the frame that the rules read; shapes of policies can reach further than those of rules."""
        module = self._env.module
        if self._pad == module.PAD:
            return state
        (_, cols), own = module.FRAME, module.PAD
        moved = {}
        for sort in body_sorts(self._game):
            at = getattr(state, attribute_of("position", sort))
            row, col = at // cols - own + self._pad, at % cols - own + self._pad
            moved[attribute_of("position", sort)] = jnp.where(
                at == 0, 0, row * (self._shape[1] + 2 * self._pad) + col
            )
        return state.replace(**moved)


def open_cells(game: ir.Game) -> np.ndarray:
    """Returns which cells agents can ever enter, `[H, W]` bool; those that block under a condition are among them."""
    kinds = kinds_by_glyph(game)
    closed = {kind.name for kind in game.kinds if blocks_always(kind)}
    return np.array([[kinds[glyph] not in closed for glyph in row] for row in game.rows])


def visible_from(
    game: ir.Game, shape: ir.Shape, heading: int
) -> Iterator[tuple[tuple[int, int], np.ndarray]]:
    """Yields each cell of a shape as seen with a heading, and from where it is not behind a cell that always blocks the shape.

    Yields:
      rows down and columns to the right of the agent, and `[H, W]` bool over the agent's cells.
    """
    kinds = kinds_by_glyph(game)
    stops = {kind.name for kind in game.kinds if blocks_always(kind, shape.name)}
    blocking = np.array([[kinds[glyph] in stops for glyph in row] for row in game.rows])
    met = {(0, 0)}
    for lane in shape.lanes:
        free = np.ones(blocking.shape, bool)
        for offset in turned(lane, heading):
            place = (offset[0] % blocking.shape[0], offset[1] % blocking.shape[1])
            if game.wraps and place in met and offset != (0, 0):  # a cell of the shape already
                continue
            met.add(place)
            yield offset, free
            if not shape.see_through:
                free = free & ~_found_at(blocking, *offset, game.wraps)


def _found_at(cells: np.ndarray, rows: int, cols: int, wraps: bool) -> np.ndarray:
    """Returns for each cell of the map whether the cell so many rows down and columns to the right of it is one of `cells`."""
    height, width = cells.shape
    margin = (0, 0) if wraps else (abs(rows), abs(cols))
    framed = np.roll(np.pad(cells, [(side, side) for side in margin]), (-rows, -cols), (0, 1))
    return framed[margin[0] : margin[0] + height, margin[1] : margin[1] + width]
