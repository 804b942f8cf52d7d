"""Scripted policies as JAX functions of the state: an agent follows the first rule that applies."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.queries import blocks_always, body_types, kinds_by_glyph, shape_named
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

HALF = 1 << 31  # 32 random bits are below it with probability one half
Poses = tuple[Array, Array, Array]  # heading, row and column of each agent, `[N]` each


class Situation(NamedTuple):
    """What agents choose their actions by.

    state: with positions in the frame of the lowered rules.
    poses: of the agents. present: `[N]` bool, who is on the map.
    bits: `[N, 2]` uint32, 64 random bits for each agent.
    """

    state: Any
    poses: Poses
    present: Array
    bits: Array


def scripted_policy(env: Any, name: str) -> MemoryPolicy:
    """Returns a policy that the game's file declares.

    It reads the state, not the observation, and needs no memory. One compilation serves all agents.

    Args:
      env: a `sjdsl.Environment`, or a wrapper with its attributes.

    Raises:
      KeyError: the game has no policy of that name.
      NotSupported: the policy reads something that the compiler doesn't support.
    """
    choose = Chooser(env, declared_policies(env)[name])

    def act(memory: Any, key: Array, observation: Array, state: Any) -> tuple[Any, Array]:
        del observation
        numbers = jnp.arange(2 * env.num_agents, dtype=jnp.uint32)
        bits = random_bits_at(key_words(key), 0, numbers).reshape(env.num_agents, 2)
        return memory, choose(state, bits)

    return MemoryPolicy((), act, reads_state=True)


class Chooser:
    """What the agents of one policy do in a state."""

    def __init__(self, env: Environment, policy: ir.ScriptedPolicy):
        """Raises NotSupported."""
        self._env = env
        self._game: ir.Game = env.game
        lowered = lower_policy(policy, self._game)
        self._rules = lowered.rules
        self._closed = lowered.closed
        self._pad = lowered.pad
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
          bits: `[N, 2]` uint32, 64 random bits for each agent.
        """
        row, col = self._env.cells(state)
        poses = (state.heading, row, col)
        undecided = state.position != 0
        situation = Situation(self._reframed(state), poses, undecided, bits)
        actions = jnp.full(self._env.num_agents, self._stay, jnp.int32)
        for rule in self._rules:
            applies, followed = self._follow(rule, situation, undecided)
            actions = jnp.where(undecided & applies, followed, actions)
            undecided = undecided & ~applies
        return actions

    def _follow(
        self, lowered: LoweredRule, situation: Situation, undecided: Array
    ) -> tuple[Array, Array]:
        """Returns to which agents a rule applies, `[N]` bool, and their actions, `[N]` int32."""
        rule = lowered.rule
        state = situation.state
        poses = situation.poses
        may_apply = jnp.asarray(True)
        if lowered.condition is not None:
            may_apply = lowered.condition(state, self._env.params)
        if isinstance(rule, ir.Act):
            return may_apply, self._final_action(lowered, state)
        if lowered.sought is None:
            return jnp.zeros_like(undecided), jnp.zeros_like(poses[0])
        undecided = undecided & may_apply
        members = self._board(lowered.sought, state)
        enterable = board(jnp.asarray(self._moves.open))[None]
        for cells in self._closed:
            enterable = enterable & ~self._board(cells, state)
        if lowered.avoided is not None:
            avoided = self._board(lowered.avoided, state)
            if isinstance(rule, ir.Go):
                avoided = avoided & ~members
            enterable = enterable & ~avoided
        if isinstance(rule, ir.Go):
            num_headings = 4 if self._moves.turns_matter else 1
            goals = jnp.repeat(members[:, None], num_headings, axis=1)
            at_goal = jnp.int32(self._stay)
        else:
            goals = self._aiming_poses(rule, members)
            at_goal = self._final_action(lowered, state)
        if not self._moves.actions:  # nobody can walk: a rule applies to those at a goal
            is_at_goal = may_apply & self._is_at_goal(goals, poses)
            return is_at_goal, jnp.broadcast_to(at_goal, poses[0].shape)
        arrived, has_path, best = first_moves(self._moves, goals, enterable, poses, undecided)
        moves = self._walk(best, enterable, situation)
        return may_apply & has_path, jnp.where(arrived, at_goal, moves)

    def _is_at_goal(self, goals: Array, poses: Poses) -> Array:
        """Returns which agents are at a goal, `[N]` bool. goals: `[K, P, H, L]` boards."""
        heading, row, col = poses
        agents = jnp.arange(row.shape[0])
        # One board for all agents or one each, with one plane or one for each heading.
        board_of_agent = agents if goals.shape[0] > 1 else 0
        plane = heading if goals.shape[1] > 1 else jnp.zeros_like(heading)
        goals_of_agent = goals[board_of_agent, plane]
        return contains(goals_of_agent, agents[:, None], row[:, None], col[:, None])[:, 0]

    def _final_action(self, lowered: LoweredRule, state: Any) -> Array:
        """Returns the action of each agent that a rule leads to, `[N]` int32."""
        assert not isinstance(lowered.rule, ir.Go)
        if lowered.action is None:
            return jnp.full(self._env.num_agents, lowered.rule.action, jnp.int32)
        action: Array = lowered.action(state, self._env.params)
        return action

    def _movers(self, state: Any) -> list[Array]:
        """Returns the positions of the movers of each type, `row * width + column` of the map.

        They are -1 for those that are away.
        """
        width = self._shape[1]
        padded_width = width + 2 * self._pad
        positions = []
        for mover in self._game.movers:
            position = getattr(state, attribute_of("position", mover.entity_type))
            row = position // padded_width - self._pad
            col = position % padded_width - self._pad
            positions.append(jnp.where(position == 0, -1, row * width + col))
        return positions

    def _walk(self, best: Array, enterable: Array, situation: Situation) -> Array:
        """Returns the actions of moves, `[N]` int32: `best` unless somebody is in the way.

        If an agent or a mover is, half of the time a move is drawn from those that enter nothing
        avoided.
        """
        heading, row, col = situation.poses
        bits = situation.bits
        num_agents = row.shape[0]
        destinations = []
        for step in self._moves.steps:
            cells = (row, col)
            if step is not None:
                cells = destination(self._moves, step, heading, row, col)
            destinations.append(cells)
        rows, cols = (jnp.stack(numbers, axis=-1) for numbers in zip(*destinations, strict=True))
        boards = jnp.zeros(num_agents, jnp.int32)
        if enterable.shape[0] > 1:
            boards = jnp.arange(num_agents)
        board_of_move = jnp.broadcast_to(boards[:, None], rows.shape)
        is_enterable = contains(enterable, board_of_move, rows, cols)
        allowed = is_enterable | ((rows == row[:, None]) & (cols == col[:, None]))
        to_row = jnp.take_along_axis(rows, best[:, None], axis=1)
        to_col = jnp.take_along_axis(cols, best[:, None], axis=1)
        others = situation.present[None] & ~jnp.eye(num_agents, dtype=bool)
        blocked = jnp.any((to_row == row[None]) & (to_col == col[None]) & others, axis=1)
        for position in self._movers(situation.state):
            is_mover_there = (to_row * self._shape[1] + to_col) == position[None]
            blocked = blocked | jnp.any(is_mover_there, axis=1)
        index = below(bits[:, 0], jnp.sum(allowed, axis=1))
        drawn = jnp.argmax(jnp.cumsum(allowed, axis=1) > index[:, None], axis=1)
        draws = blocked & (bits[:, 1] < jnp.uint32(HALF))
        moves = jnp.where(draws, drawn.astype(jnp.int32), best)
        return jnp.asarray(self._moves.actions, jnp.int32)[moves]

    def _board(self, cells: Cells, state: Any) -> Array:
        """Returns the cells of members as boards, `[N or 1, H, L]`."""
        height, width = self._shape
        if cells.numbers is not None:
            members = cells.read(state, self._env.params)
            no_cell = jnp.zeros((members.shape[0], 1), bool)
            padded = jnp.concatenate([members, no_cell], axis=1)
            on_map = padded[:, jnp.asarray(cells.numbers)]
            return board(on_map.reshape(-1, height, width))
        members, positions = cells.read(state, self._env.params)
        row = jnp.arange(members.shape[0])[:, None]
        cell = jnp.where(members, positions, height * width)
        empty = jnp.zeros((members.shape[0], height * width), bool)
        on_map = empty.at[row, cell].set(True, mode="drop")
        return board(on_map.reshape(-1, height, width))

    def _aiming_poses(self, rule: ir.Aim, members: Array) -> Array:
        """Returns the poses from which a member is in the shape, `[K, P, H, L]` boards."""
        game = self._game
        all_shapes = game.model_copy(update={"shapes": (*game.shapes, *game.policy_shapes)})
        shape = shape_named(all_shapes, rule.shape)
        moved = wrapped if game.wraps else shifted
        planes = []
        for heading in range(4 if shape.directed or self._moves.turns_matter else 1):
            poses = jnp.zeros_like(members)
            for (rows, cols), visible in visible_from(game, shape, heading):
                agents = moved(members, -rows, -cols, self._shape[1])
                poses = poses | (agents & board(jnp.asarray(visible))[None])
            planes.append(poses)
        return jnp.stack(planes, axis=1)

    def _reframed(self, state: Any) -> Any:
        """Returns the state with positions in the frame of the lowered rules.

        It may be wider than the environment's: shapes of policies may reach further.
        """
        module = self._env.module
        if self._pad == module.PAD:
            return state
        _, old_width = module.FRAME
        new_width = self._shape[1] + 2 * self._pad
        added = self._pad - module.PAD
        positions = {}
        for entity_type in body_types(self._game):
            attribute = attribute_of("position", entity_type)
            old = getattr(state, attribute)
            row = old // old_width + added
            col = old % old_width + added
            positions[attribute] = jnp.where(old == 0, 0, row * new_width + col)
        return state.replace(**positions)


def open_cells(game: ir.Game) -> np.ndarray:
    """Returns which cells agents can ever enter, `[H, W]` bool."""
    kinds = kinds_by_glyph(game)
    closed = {kind.name for kind in game.kinds if blocks_always(kind)}
    return np.array([[kinds[glyph] not in closed for glyph in row] for row in game.rows])


def visible_from(
    game: ir.Game, shape: ir.Shape, heading: int
) -> Iterator[tuple[tuple[int, int], np.ndarray]]:
    """Yields each cell of a shape, with the cells from which an agent reaches it.

    It doesn't reach behind a cell that always blocks the shape.

    Yields:
      rows down and columns to the right of the agent; `[H, W]` bool over the agent's cells.
    """
    kinds = kinds_by_glyph(game)
    blocking_kinds = {kind.name for kind in game.kinds if blocks_always(kind, shape.name)}
    blocking = np.array([[kinds[glyph] in blocking_kinds for glyph in row] for row in game.rows])
    height, width = blocking.shape
    yielded = {(0, 0)}
    for lane in shape.lanes:
        reaches = np.ones((height, width), bool)
        for rows, cols in turned(lane, heading):
            cell = (rows % height, cols % width)
            is_same_cell = game.wraps and cell in yielded and (rows, cols) != (0, 0)
            if is_same_cell:  # around the edge of the map
                continue
            yielded.add(cell)
            yield (rows, cols), reaches
            if not shape.see_through:
                reaches = reaches & ~_shifted_cells(blocking, rows, cols, game.wraps)


def _shifted_cells(cells: np.ndarray, rows: int, cols: int, wraps: bool) -> np.ndarray:
    """Returns, for each cell, the value of the one some rows down and columns to the right.

    Off the map, it is False.
    """
    if wraps:
        return np.roll(cells, (-rows, -cols), (0, 1))
    height, width = cells.shape
    top = abs(rows)
    left = abs(cols)
    padded = np.pad(cells, [(top, top), (left, left)])
    shifted_cells = np.roll(padded, (-rows, -cols), (0, 1))
    return shifted_cells[top : top + height, left : left + width]
