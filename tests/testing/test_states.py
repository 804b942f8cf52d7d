"""Whatever state a game can be in can be put as a scene; pictures number any number of agents."""

import random
import shutil
from pathlib import Path
from typing import Any

import pytest

from sjdsl.compiler.ir.queries import all_fields
from sjdsl.interpreter.state import World
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.games_folder import main_games
from sjdsl.testing import Stage
from sjdsl.testing.paths import find_field, read_field

HERE = Path(__file__).parent
GAMES = [
    *main_games(),
    HERE / "camp.sj",
    *sorted((HERE.parent / "differential" / "games").glob("*.sj")),
]


def path_of(declared: Any) -> str:
    return (
        declared.name
        if declared.held_by.what == "world"
        else f"{declared.held_by.name}.{declared.name}"
    )


def put_again(stage: Stage, world: World) -> World:
    """Returns the world of a scene made to be like another: places in a picture, the rest by name."""
    rows = [list(row) for row in stage.env.game.rows]
    standing: list[list[tuple[int, int]]] = [[] for _ in rows]
    for agent, place in enumerate(world.position):
        if place is not None:
            rows[place.row][place.col] = stage.arrows[world.heading[agent]]
            standing[place.row].append((place.col, agent))
    orders: dict[str, list[int]] = {}
    for sort in stage.env.game.movers:
        places = {
            place: number
            for number, place in enumerate(world.movers[sort.name].position)
            if place is not None
        }
        orders[sort.name] = [number for _, number in sorted(places.items())]
        for row, col in places:
            rows[row][col] = sort.glyph
    numbers = [",".join(str(agent) for _, agent in sorted(row)) for row in standing]
    picture = [
        f"{''.join(row)}  {told}" if told else "".join(row)
        for row, told in zip(rows, numbers, strict=True)
    ]
    labels = {
        phase.name: phase.label for phase in stage.env.game.schedule if hasattr(phase, "name")
    }
    away, *movers_away = (
        {
            i: (a.ticks, labels[a.pool.phase]) if a.pool else 0
            for i, a in enumerate(herd.away)
            if a is not None
        }
        for herd in (world, *world.movers.values())
    )
    fields = {
        path_of(f): read_field(find_field(stage.env.game, path_of(f)), world)
        for f in all_fields(stage.env.game)
    }
    return stage.put(
        *picture,
        fields=fields,
        away=away,
        movers_away=dict(zip(world.movers, movers_away, strict=True)),
        numbers=orders,
        step=world.step,
    ).world


@pytest.mark.thorough
@pytest.mark.parametrize("game", GAMES, ids=[Path(game).stem for game in GAMES])
def test_every_state_can_be_put(game: str | Path) -> None:
    """States of random play. Who has moved is not put, nor the heading of one that is away, which shows only if it returns as it was."""
    stage = Stage(game, arrows="\u2191\u2192\u2193\u2190")
    params, chance = stage.numbers({}).interpreted, random.Random(0)
    world = reset(stage.env.game, params, Threefry(1, 2))
    for number in range(6):
        actions = [chance.randrange(stage.env.num_actions) for _ in range(stage.env.num_agents)]
        world, _ = step(stage.env.game, world, actions, params, Threefry(number, 3))
        if number % 3 == 2:
            again = put_again(stage, world)
            assert (again.cells, again.agents, again.fields) == (
                world.cells,
                world.agents,
                world.fields,
            )
            assert (again.position, again.away, again.step) == (
                world.position,
                world.away,
                world.step,
            )
            for sort, herd in world.movers.items():
                own = again.movers[sort]
                assert (own.position, own.away, own.fields) == (
                    herd.position,
                    herd.away,
                    herd.fields,
                )
            assert all(
                a == b
                for a, b, place in zip(again.heading, world.heading, world.position, strict=True)
                if place
            )


def test_twelve_agents() -> None:
    stage = Stage("mushrooms", ("............", "............"), 12)
    scene = stage.put("^>v<.....>>.  11,0,1,2,10,3", "<<<^^^......")
    assert scene.places()[:4] == [(0, 1), (0, 2), (0, 3), (0, 10)]
    assert scene.places()[4:] == [(1, 0), (1, 1), (1, 2), (1, 3), (1, 4), (1, 5), (0, 9), (0, 0)]
    assert scene.picture() == ["^>v<.....>>.  11,0,1,2,10,3", "<<<^^^......  456789"]
    scene.shows("^>v<.....>>.", "<<<^^^......  456789")


def test_one_agent_with_a_number_of_two_digits() -> None:
    stage = Stage("mushrooms", ("............", "............"), 12)
    scene = stage.put("^...........  10", "<<<^^^^^^^^.")
    assert scene.places()[10] == (0, 0)
    assert scene.picture()[0] == "^...........  10"
    with pytest.raises(AssertionError, match="the map differs"):
        scene.shows("^...........  11", "<<<^^^^^^^^.")


def test_a_map_of_a_file_with_the_glyph_of_an_arrow(tmp_path: Path) -> None:
    """A game of one's own, its floor drawn with `v`, in a variant."""
    game = (
        (HERE.parents[1] / "games" / "harvest_open.sj")
        .read_text(encoding="utf-8")
        .replace('kind floor "."', 'kind floor "v"')
    )
    shutil.copytree(
        HERE.parents[1] / "games/meltingpot/shared", tmp_path / "meltingpot/shared"
    )  # what it extends
    (tmp_path / "field.sj").write_text(
        game.replace("maps/harvest_open.txt", "room.txt"), encoding="utf-8"
    )
    (tmp_path / "room.txt").write_text("QQPvP\nvvvvv\n", encoding="utf-8")
    stage = Stage(
        tmp_path / "field.sj", tmp_path / "room.txt", 2, variant="socialjax", arrows="nesw"
    )
    scene = stage.put("QQPvP", "vnvev")
    assert (scene.headings(), scene.picture()) == (["north", "east"], ["QQPvP", "vnvev  01"])
    assert not stage.env.game.agents.relative
