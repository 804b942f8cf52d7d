"""The dm_env adapter: what Melting Pot's checks of a substrate ask for, and pictures that show what is there."""

from pathlib import Path

import dm_env
import numpy as np
import pytest

from sjdsl import make
from sjdsl.interop.dm_env import TILE, Substrate, build, get_config

LENGTH = 6
SHORT = {"params": {"length": LENGTH}}


def assert_fits(env: Substrate, step: dm_env.TimeStep) -> None:
    """Discount, rewards and observations, key by key, as the specs say."""
    env.discount_spec().validate(step.discount)
    assert (
        len(step.reward)
        == len(env.reward_spec())
        == len(step.observation)
        == len(env.observation_spec())
    )
    for reward, spec in zip(step.reward, env.reward_spec(), strict=True):
        spec.validate(reward)
    for observation, spec in zip(step.observation, env.observation_spec(), strict=True):
        assert set(observation) == set(spec)
        for name in spec:
            spec[name].validate(observation[name])


@pytest.mark.parametrize("game", ["coins", "harvest_open", "pd_arena"])
def test_steps_match_the_specs(game: str) -> None:
    env = Substrate(game, seed=0, **SHORT)
    assert_fits(env, env.reset())
    step = env.step([spec.maximum for spec in env.action_spec()])
    assert_fits(env, step)
    assert ("READY_TO_SHOOT" in step.observation[0]) == (game != "coins")
    assert step.observation[0]["RGB"].shape == (88, 88, 3)


def test_an_episode_is_cut_off_and_another_begins() -> None:
    env = Substrate("coins", seed=0, **SHORT)
    first = env.step([0, 0])  # before reset
    assert first.first() and first.reward == [0, 0]
    steps = [env.step([step % 7, 1]) for step in range(LENGTH)]
    assert [step.step_type for step in steps] == [dm_env.StepType.MID] * (LENGTH - 1) + [
        dm_env.StepType.LAST
    ]
    assert {step.discount for step in steps} == {1.0}
    assert env.step([0, 0]).first()


def test_windows_are_turned_so_that_ahead_is_up() -> None:
    """Each agent's own cell, and the cell before it, are the world's, turned; off the map all is dark."""
    tile = 8
    env = Substrate("harvest_open", seed=3)
    observations = env.reset().observation
    world = observations[0]["WORLD.RGB"]
    height, width = world.shape[0] // tile, world.shape[1] // tile
    padded = np.zeros(((height + 20) * tile, (width + 20) * tile, 3), np.uint8)
    padded[10 * tile : -10 * tile, 10 * tile : -10 * tile] = world
    row, col = (np.asarray(x) for x in env.env.cells(env._state))
    headings = np.asarray(env._state.heading)
    assert len(set(headings.tolist())) > 1
    for player, observation in enumerate(observations):
        top, left = row[player] + 10 - 9, col[player] + 10 - 9
        square = padded[top * tile : (top + 19) * tile, left * tile : (left + 19) * tile]
        upright = np.rot90(square, int(headings[player]))
        np.testing.assert_array_equal(
            observation["RGB"], upright[: 11 * tile, 4 * tile : 15 * tile]
        )


def test_rewards_and_events_are_the_games() -> None:
    env = Substrate("coins", seed=4)
    env.reset()
    coins = total = 0
    for step in range(300):
        made = env.step([(5 * step) % 7, (3 * step + step // 7) % 7])
        assert float(made.observation[1]["COLLECTIVE_REWARD"]) == sum(made.reward)
        for name, what in env.events():
            assert name in ("own_coins", "other_coins")
            assert what["player"] in (0, 1)
            coins += what["times"]
            total += what["times"] * (1 if name == "own_coins" else -1)
        total -= sum(made.reward)
    assert coins > 0
    assert total == 0


def test_configurations_and_roles() -> None:
    config = get_config("harvest_open")
    assert config.default_player_roles == ("default",) * 7
    assert config.valid_roles == {"default"}
    assert config.action_names[-1] == "zap"
    assert config.individual_observation_names == ("RGB", "READY_TO_SHOOT", "COLLECTIVE_REWARD")
    assert len(build("harvest_open", ["default"] * 4, seed=0).reset().observation) == 4
    with pytest.raises(ValueError, match="there is no role `boss`"):
        build("harvest_open", ["boss"])


def test_substrates_are_taken_by_their_names() -> None:
    config = get_config("bach_or_stravinsky_in_the_matrix__repeated")
    assert config.default_player_roles == ("bach_fan", "stravinsky_fan")
    env = build("bach_or_stravinsky_in_the_matrix__repeated", config.default_player_roles, seed=0)
    assert env.env.num_agents == 2
    assert env.observation_spec()[0]["RGB"].shape == (40, 40, 3)  # Melting Pot's
    with pytest.raises(ValueError, match="give them in this order"):
        build("bach_or_stravinsky_in_the_matrix__repeated", ["stravinsky_fan", "bach_fan"])
    with pytest.raises(ValueError, match="the roles are bach_fan, stravinsky_fan"):
        build("bach_or_stravinsky_in_the_matrix__repeated", ["default"] * 2)


def test_pictures_show_no_more_than_is_seen(tmp_path: Path) -> None:
    """Agent 1 sees less far."""
    file = tmp_path / "dusk.sj"
    file.write_text(
        """sj 1 game dusk "Dusk" { episode 5  kind grass "."  map { "...." }  agents 2 { acts stay }
        phase start { each agent { send agent to grass facing north } }  schedule rest  phase rest { }
        observe { window ahead 0, behind 0, left 3, right 3  window left 1, right 1 when agent.index == 1 } }"""
    )
    env = Substrate(str(file), seed=1)
    first, second = env.reset().observation
    world, tile = first["WORLD.RGB"], TILE
    own, other = (int(column) for column in np.asarray(env.env.cells(env._state)[1]))
    for column in range(4):
        here = world[:, column * tile : (column + 1) * tile]
        place = 3 + column - other
        if 0 <= place < 7:
            far = abs(column - other) > 1
            expected = np.zeros_like(here) if far else here
            assert np.array_equal(second["RGB"][:, place * tile : (place + 1) * tile], expected)
        place = 3 + column - own
        assert np.array_equal(first["RGB"][:, place * tile : (place + 1) * tile], here)


@pytest.mark.parametrize("name", ["clean_up", "coins", "coop_mining"])
def test_a_name_of_both_is_the_substrate_unless_a_variant_is_given(name: str) -> None:
    assert Substrate(name).env.hash == make(name, variant="meltingpot").hash
    assert Substrate(name, variant=None).env.hash == make(name).hash
    assert Substrate(name, variant="socialjax").env.hash == make(name, variant="socialjax").hash


def test_a_substrate_gives_what_the_original_lists() -> None:
    """Shapes and types as there: the matrix, and the vote."""
    env = Substrate("prisoners_dilemma_in_the_matrix__repeated", seed=0)
    assert_fits(env, env.reset())
    step = env.step([env.action_names.index("interact"), 0])
    assert_fits(env, step)
    seen = step.observation[0]
    assert (seen["INVENTORY"].shape, seen["INTERACTION_INVENTORIES"].tolist()) == (
        (2,),
        [[-1, -1], [-1, -1]],
    )
    assert [float(o["READY_TO_SHOOT"]) for o in step.observation] == [0, 1]
    assert float(env.step([0, 0]).observation[0]["READY_TO_SHOOT"]) == 0.5
    agenda = Substrate("hidden_agenda", seed=0)
    first = agenda.reset()
    assert_fits(agenda, first)
    assert first.observation[0]["VOTING"].tolist() == np.eye(7)[[5] * 5].tolist(), (
        "nobody has a vote yet, and nobody is out"
    )
    assert [name for name in first.observation[0] if name.isupper() and "." not in name] == [
        *("RGB", "INVENTORY", "READY_TO_SHOOT", "VOTING", "COLLECTIVE_REWARD")
    ]
    names = get_config("predator_prey__open").individual_observation_names
    assert names == ("RGB", "STAMINA", "COLLECTIVE_REWARD")
