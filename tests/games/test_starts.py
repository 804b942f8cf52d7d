"""Where agents begin, in every game, variant and room: over many resets, each start as often as it should be."""

import jax
import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.runtime.env import Environment

from .chance import assert_uniform, times
from .environments import HARVESTS, NINE, environment, places
from .found import Form, forms, rules_of

RESETS = 40_000
# glyphs of the cells where agents begin; the first two agents of Harvest have two cells of their own. Source: the released code
STARTS = {
    "coins": "P",
    **dict.fromkeys(HARVESTS, "P"),
    "clean_up": "P",
    "coop_mining": "P",
    "gift_refinement": "P",
    "pd_arena": "P",
}
STARTS |= {"mushrooms": "."}


def different_starts() -> list[Form]:
    """Returns the forms of the nine games whose maps, agents or starts differ."""
    found: dict[object, Form] = {}
    for form in forms():
        if form.game in NINE and form.variant != "meltingpot":  # the same sentences on other maps
            rules = rules_of(form)
            sends = tuple(
                node.cell_stream for node in ir.walk(rules.start) if isinstance(node, ir.Send)
            )
            found.setdefault((rules.rows, rules.agents.number, sends), form)
    return list(found.values())


def poses(form: Form) -> tuple[np.ndarray, np.ndarray]:
    """Returns the (row, col) `[resets, agents, 2]` and headings `[resets, agents]` of many resets."""
    env = environment(*form)

    def pose(key: jax.Array) -> tuple[jax.Array, jax.Array]:
        _, state = env.reset(key)
        return state.position, state.heading

    position, heading = jax.jit(jax.vmap(pose))(jax.random.split(jax.random.key(3), RESETS))
    return places(env, position), np.asarray(heading)


def numbers(cells: np.ndarray, starts: list[tuple[int, int]]) -> np.ndarray:
    """Returns the number of each cell among the starts; all are such."""
    index = {cell: i for i, cell in enumerate(starts)}
    return np.vectorize(lambda r, c: index[r, c])(cells[..., 0], cells[..., 1])


def glyphs(env: Environment, wanted: str) -> list[tuple[int, int]]:
    """Returns the cells of the map with these glyphs, in reading order."""
    return [
        (r, c)
        for r, row in enumerate(env.game.rows)
        for c, glyph in enumerate(row)
        if glyph in wanted
    ]


@pytest.mark.parametrize(
    "form",
    [
        pytest.param(f, marks=pytest.mark.thorough if f.variant or f.agents else [])
        for f in different_starts()
    ],
    ids=str,
)
def test_starts(form: Form) -> None:
    """Different cells; each agent on each of them, looking each way, equally often; no two of these tell of each other."""
    cells, heading = poses(form)
    env, agents = environment(*form), cells.shape[1]
    assert agents == rules_of(form).agents.number
    inner = 2 if form.game in HARVESTS else 0
    flat = cells[..., 0] * 100 + cells[..., 1]
    assert (np.diff(np.sort(flat, axis=1), axis=1) > 0).all()
    for agent in range(agents):
        assert_uniform(times(heading[:, agent], 4), 0.05)
    if inner:
        dens = numbers(cells[:, :2], glyphs(env, "Q"))
        assert (dens.sum(axis=1) == 1).all()
        assert_uniform(times(dens[:, 0], 2), 0.04)
    starts = glyphs(env, STARTS[form.game])
    outer = numbers(cells[:, inner:], starts)
    for agent in range(outer.shape[1]):
        assert_uniform(times(outer[:, agent], len(starts)), 0.3 if len(starts) < 65 else 0.6)
    if len(starts) > 2:
        low = (
            outer < len(starts) / 2
        )  # the half of the map it begins in, and the way another agent, or it, looks
        for a, b in ((0, 1), (1, outer.shape[1] - 1)):
            for half in (False, True):
                assert_uniform(times(heading[low[:, a] == half][:, inner + b], 4), 0.08)
                assert_uniform(times(heading[low[:, a] == half][:, inner + a], 4), 0.08)
    else:
        assert_uniform(times(outer[:, 0] * 4 + heading[:, 0], 8), 0.1)
    assert_uniform(times(heading[:, 0] * 4 + heading[:, 1], 16), 0.15)


def test_all_nine_are_found() -> None:
    assert {form.game for form in different_starts()} == set(NINE)
