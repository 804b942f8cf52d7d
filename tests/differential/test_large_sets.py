"""Sets of agents in games of up to 64 agents: the compiled step equals the interpreter, and states of both are turned into each other."""

from pathlib import Path

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.interpreter.state import World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.stored import held_values
from sjdsl.interpreter.threefry import Threefry
from sjdsl.properties.state_conversion import world_of
from sjdsl.render.appearance import cell_keys
from sjdsl.render.look import make_look
from sjdsl.runtime.env import Environment
from sjdsl.testing.states import compiled_state
from tests.fuzz.judge import on_jax
from tests.fuzz.together import forms, interpret, module_text, of_text, random_play, run

GAME = Path(__file__).parent / "large_sets.sj"


@pytest.mark.parametrize("agents", [8, 33, 40, 64])
def test_compiled_and_interpreted_agree(agents: int) -> None:
    """Every operation of sets, on NumPy, step by step; and the shapes and dtypes of the same module under JAX's strict rules."""
    game = build(
        Source("large_sets.sj", GAME.read_text("utf-8").replace("= 40 in", f"= {agents} in"))
    ).game
    play = random_play(game, seed=agents, steps=8)
    text = module_text(game)
    report = run(of_text(game, text), play, interpret(game, play))
    assert not report.differences, report.differences
    assert report.steps == 8
    if agents == 33:  # tracing takes longer than all else
        assert not forms(on_jax(game, text))


@pytest.fixture(scope="module")
def crowd() -> Environment:
    return sjdsl.make(GAME, num_agents=64)


@pytest.fixture(scope="module")
def world(crowd: Environment) -> World:
    """Returns a state in which sets have members below and above number 32."""
    made, chance = (
        reset(crowd.game, default_params(crowd.game), Threefry(1, 2)),
        np.random.default_rng(0),
    )
    for number in range(2):
        actions = chance.integers(0, crowd.num_actions, crowd.num_agents).tolist()
        made, _ = step(crowd.game, made, actions, default_params(crowd.game), Threefry(number, 3))
    club = made.fields["club"]
    assert isinstance(club, frozenset)
    assert club & set(range(32))
    assert club & set(range(32, 64))
    return made


def test_states_are_turned_into_each_other(crowd: Environment, world: World) -> None:
    state = compiled_state(crowd, crowd.module.initial_state(), world)
    assert state.world_club.shape == (2,)
    assert state.agent_met.shape == (64, 64, 2)
    again = world_of(crowd, state)
    for declared in all_fields(crowd.game):
        assert held_values(declared, again) == held_values(declared, world), declared.name


def test_the_vector_has_an_entry_for_each_agent(crowd: Environment, world: World) -> None:
    state = jax.tree.map(
        jax.numpy.asarray, compiled_state(crowd, crowd.module.initial_state(), world)
    )
    vector = np.asarray(jax.jit(crowd.state_vector)(state))
    sizes = {"agents": 64, "agent": 64, "number": 1}
    place = 1 + 64 * (3 + 4)
    for field in crowd.module.FIELDS:
        stored = np.asarray(getattr(state, field.attribute))
        size = stored.size // (2 if field.encoding == "agents" else 1) * sizes[field.encoding]
        if field.attribute == "world_club":
            assert set(np.flatnonzero(vector[place : place + size])) == world.fields["club"]
        place += size
    assert place == len(vector)


def test_pictures_show_how_many_are_in_a_set(crowd: Environment, world: World) -> None:
    """A bar of eighths: of 64 agents one for each eight, rounded up."""
    (look,) = (kind for kind in make_look(crowd.game).kinds if kind.name == "grass")
    visitors = world.cells["grass", "visitors"]
    values = {
        name: np.asarray(array)
        for name, array in vars(compiled_state(crowd, crowd.module.initial_state(), world)).items()
    }
    keys, number = cell_keys(look, values)
    place = [field.name for field in look.fields].index("visitors")
    assert [keys[cell][place] for cell in number] == [-(-len(members) // 8) for members in visitors]  # type: ignore[arg-type]


def test_more_than_64_agents_are_refused() -> None:
    with pytest.raises(sjdsl.CompileError, match=r"players.*(64|65)"):
        sjdsl.make(GAME, num_agents=65)
