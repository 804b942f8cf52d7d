"""What was decided for each game: its numbers, order of events, moves, beams and observables, by default and in each variant.

Every number of a game stands here once more, with its source: `paper` for the SocialJax paper, `released code` for its code, `MP` for
Melting Pot. A variant differs from the default in what stands under its name and in nothing else that is looked at here.
"""

from typing import Any, NamedTuple

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game

from .environments import NINE

MOVES = (
    "turn_left",
    "turn_right",
    "step_left",
    "step_right",
    "forward",
    "backward",
    "stay",
)  # released code: 0 .. 6
T_SHAPE = {
    (1, 0),
    (2, 0),
    (1, -1),
    (1, 1),
}  # released code: two ahead, and both diagonals; (ahead, right)


def lanes(length: int) -> set[tuple[int, int]]:
    """Returns the cells of a beam of Melting Pot: a line ahead, and one on each side that starts beside the agent."""
    return {(ahead, 0) for ahead in range(1, length + 1)} | {
        (ahead, side) for ahead in range(length) for side in (-1, 1)
    }


class Facts(NamedTuple):
    """numbers: all sizes and params. own, seen: actions beside the moves; own fields an agent sees, and those of others."""

    numbers: dict[str, Any]
    own: tuple[str, ...]
    schedule: str
    shape: set[tuple[int, int]] = frozenset()
    walls_stop: frozenset[str] = frozenset()
    seen: frozenset[str] = frozenset()
    of_others: frozenset[str] = frozenset()
    timers: frozenset[str] = frozenset()
    relative: bool = True
    rows: str = ""


def frozen(*names: str) -> frozenset[str]:
    return frozenset(names)


HARVEST = Facts(
    numbers={
        "players": 7, "length": 1000, "apple": 1.0, "regrow_1": 0.001, "regrow_2": 0.005, "regrow_3": 0.025,  # paper
        "respawn_delay": 0,  # released code: at once
    },
    own=("zap",),
    schedule="regrow tick walk eat fire",  # decided: growth first, on the state the agents saw
    shape=T_SHAPE,
    walls_stop=frozen("agents", "beam"),
)  # fmt: skip
DEFAULT = {
    "coins": Facts(
        numbers={"players": 2, "length": 1000, "spawn": 0.0005, "coin": 1.0, "harm": -2.0},  # paper
        own=(),
        schedule="grow walk take",
    ),
    "harvest_open": HARVEST,
    "harvest_closed": HARVEST,
    "harvest_partnership": HARVEST,
    "clean_up": Facts(
        numbers={
            "players": 7, "length": 1000, "apple": 1.0, "grace": 50, "pollution": 0.5,  # paper
            "best_rate": 0.05, "spoiled_at": 0.4, "perfect_at": 0.0, "respawn_delay": 0,  # released code
        },
        own=("zap", "clean"),
        schedule="grow pollute tick walk eat scrub rinse fire",  # ours: rinse, so that each cleaned cell counts once
        shape=T_SHAPE,
        walls_stop=frozen("agents", "beam"),
    ),
    "coop_mining": Facts(
        numbers={
            "players": 6, "length": 1000, "iron_pays": 1.0, "gold_pays": 8.0, "spawn_iron": 0.0004, "spawn_gold": 0.00016,  # paper
            "fewest": 2, "most": 4, "patience": 3, "reach": 3,  # paper; the reach: released code
        },
        own=("mine",),
        schedule="walk mine settle tick close grow",  # decided: growth last in this game
        shape={(1, 0), (2, 0), (3, 0)},
        walls_stop=frozen("agents", "ray"),
    ),
    "gift_refinement": Facts(
        numbers={
            "players": 5, "length": 1000, "cap": 15, "spawn": 0.0002, "worth": 1.0,  # paper
            "yields": (3, 3, 1), "becomes": ("cut", "fine", "fine"), "reach": 1,  # paper: tripled; released code
        },
        own=("gift", "consume"),
        schedule="grow walk collect consume offer receive(cut) receive(fine)",  # decided: consumed before gifts arrive
        shape={(1, 0)},
        walls_stop=frozen("agents", "ray"),
        seen=frozen("bag"),  # decided
    ),
    "mushrooms": Facts(
        numbers={
            "players": 5, "length": 1000, "respawn_delay": 0,
            "eater": (1.0, 0.0, 0.0, 0.0), "everyone": (0.0, 0.4, 0.0, -0.2), "others": (0.0, 0.0, 0.75, 0.0),  # paper: 2 / 5, 3 / 4
            "digestion": (10, 15, 20, 0), "regrow": (0.25, 0.4, 0.6, 1.0),  # paper
            "spores": ((2, 0, 0, 0), (2, 2, 0, 0), (2, 2, 2, 0), (2, 0, 0, 1)), "crowd": (5, 5, 5, 65536),  # released code
        },
        own=("zap",),
        schedule="tick walk eat sprout(red) sprout(green) sprout(blue) sprout(orange) fire",  # decided: in the step of the meal
        shape=T_SHAPE,
        seen=frozen("digesting"),  # ours
        timers=frozen("digesting"),
    ),
    "pd_arena": Facts(
        numbers={
            "players": 4, "length": 1000, "rest_lo": 10, "rest_hi": 100, "payoff": ((3.0, -1.0), (5.0, 1.0)),  # paper
            "regrow": 0.1, "room": 100,  # released code; decided
        },
        own=("interact",),
        schedule="grow tick walk collect meet",
        shape={(1, 0)},
        walls_stop=frozen("agents", "reach"),
        seen=frozen("bag", "resting"),  # decided: one's own counts, and whether one is held
        timers=frozen("resting"),
    ),
}  # fmt: skip
CROWD = {"numbers": {"players": 20}}  # paper: its speed table
ROOMS_CROWD = {**CROWD, "rows": "_crowd"}
COMPASS = {"relative": False, "seen": frozen("heading")}  # ours: released windows tell half of it
THROUGH_WALLS = {**COMPASS, "walls_stop": frozen("agents")}
COOLING = {
    "seen": frozen("cooling"),
    "timers": frozen("cooling"),
}  # MP: who may use its beam knows it
BY_CHANCE = {
    "length": 5000,
    "least": 1000,
    "interval": 100,
}  # MP: episodes end after 1000 steps or more, by chance
IDENTITY = {"of_others": frozen("index")}  # MP: each player has a colour of its own
HARVEST = {"schedule": "tick walk regrow eat fire finish", **COOLING, **IDENTITY}
OPEN_BEAM = {
    **HARVEST,
    "numbers": {"respawn_delay": 4, "regrow_1": 0.0025, **BY_CHANCE, "ending": 0.15},
    "shape": lanes(3),
}  # MP
ROOM_BEAM = {
    **HARVEST,
    "numbers": {"respawn_delay": 100, **BY_CHANCE, "ending": 0.15},
    "shape": lanes(4),
    "rows": "_crowd",
}  # MP
# everything a variant changes of the above
CHANGES: dict[tuple[str, str], dict[str, Any]] = {
    ("coins", "socialjax"): COMPASS,
    ("coins", "meltingpot"): {
        "numbers": {"spawn": 0.00025, **BY_CHANCE, "least": 300, "ending": 0.05},  # MP: 0.0005 for both colours together
        "schedule": "walk grow take finish",
        "rows": "_meltingpot",
    },
    **{(game, "socialjax"): THROUGH_WALLS for game in ("harvest_open", "harvest_closed", "harvest_partnership")},
    ("clean_up", "socialjax"): {**THROUGH_WALLS, "schedule": "sample grow pollute tick walk eat scrub rinse hide_bare fire", "rows": "_socialjax"},
    ("harvest_open", "meltingpot"): OPEN_BEAM,
    ("harvest_closed", "meltingpot"): ROOM_BEAM,
    ("harvest_partnership", "meltingpot"): ROOM_BEAM,
    ("clean_up", "meltingpot"): {
        **IDENTITY,
        "numbers": {"respawn_delay": 50, **BY_CHANCE, "ending": 0.2},
        "shape": lanes(3),
        "schedule": "tick walk grow eat pollute scrub rinse fire finish",
        "seen": frozen("zap_pause", "clean_pause"),
        "timers": frozen("zap_pause", "clean_pause"),
        "rows": "_meltingpot",
    },
    ("coop_mining", "socialjax"): {**COMPASS, "numbers": {"spawn_iron": 0.0002, "spawn_gold": 0.00008}, "rows": "_meltingpot"},
    ("coop_mining", "meltingpot"): {
        **COOLING,
        **IDENTITY,
        "seen": frozen("cooling", "index"),
        "numbers": {"spawn_iron": 0.0002, "spawn_gold": 0.00008, "most": 2, **BY_CHANCE, "ending": 0.2},
        "schedule": "walk mine settle tick cool close grow finish",
        "rows": "_meltingpot",
    },
    ("gift_refinement", "socialjax"): {
        **COMPASS,
        "schedule": "grow walk fade collect cover offer receive(cut) receive(fine) sample consume",
        "rows": "_socialjax",
    },
    ("gift_refinement", "meltingpot"): {
        **IDENTITY,
        "numbers": {"players": 6, "reach": 5, "yields": (5, 5, 1), **BY_CHANCE, "ending": 0.2},
        "shape": {(ahead, 0) for ahead in range(1, 6)},
        "schedule": "grow tick walk collect consume offer receive(cut) receive(fine) cool finish",
        "seen": frozen("bag", "cooling", "index"),
        "timers": frozen("cooling"),
        "rows": "_meltingpot",
    },
    ("mushrooms", "socialjax"): {
        **COMPASS,
        "numbers": {"sown": (5, 5, 5, 1)},  # released code
        "schedule": "sprout(red) sprout(green) sprout(blue) sprout(orange) crush walk eat fire tick",
        "rows": "_socialjax",
    },
    ("mushrooms", "meltingpot"): {
        "numbers": {
            "digestion": (0, 9, 14, 14),  # MP: 0, 10, 15, 15 with the step of the meal
            "crowd": (65536,) * 4,
            "spores": ((3, 0, 0, 0), (3, 3, 0, 0), (3, 3, 3, 0), (0, 0, 0, 1)),
            "keeps": (200, 100, 75, 0), "poison": 0.25, "respawn_delay": 52,  # MP
            "cooling": 3, "frozen": 24, "recovery": 49,  # MP: 25 and 50 with the step of the hit
            **BY_CHANCE, "ending": 0.2,
        },
        "shape": lanes(3),
        "schedule": "tick spoil walk eat die sprout(red) sprout(green) sprout(blue) sprout(orange) fire judge finish",
        "seen": frozen("digesting", "hot", "stunned", "hits"),
        "of_others": frozen("hits", "index"),
        "timers": frozen("digesting", "hot", "stunned", "recovering"),
        "rows": "_meltingpot",
    },
    ("pd_arena", "socialjax"): {
        **COMPASS,
        "rows": "_socialjax",
        "schedule": "grow walk collect meet rest tick",
        "shape": {(1, 0), (2, 0)},  # released code: one cell is reached, two are marked
        "of_others": frozen("bag"),  # released code: of everybody
    },
    **{(game, "crowd"): ROOMS_CROWD for game in ("harvest_closed", "harvest_partnership", "clean_up", "coop_mining", "gift_refinement")},
    ("harvest_open", "crowd"): CROWD,
    ("mushrooms", "crowd"): {"numbers": {"players": 20, "everyone": (0.0, 0.1, 0.0, -0.2), "others": (0.0, 0.0, 3 / 19, 0.0)}},
}  # fmt: skip
HARVEST_MAPS = {
    "closed": "harvest_closed",
    "partnership": "harvest_partnership",
}  # variants that are maps


def game_of(name: str, variant: str = "") -> ir.Game:
    return build(read_source(find_game(name)), (variant,) if variant else ()).game


def facts_of(game: ir.Game, plain: ir.Game) -> Facts:
    """Returns what a game says. `rows`: what is added to the name of the map of the plain game, empty for the same map."""
    maps = {
        suffix: find_game(plain.name).parent / "maps" / f"{plain.name}{suffix}.txt"
        for suffix in ("_crowd", "_meltingpot", "_socialjax")
    }
    others = [
        suffix
        for suffix, path in maps.items()
        if path.is_file() and tuple(path.read_text().split()) == game.rows
    ]
    turns = [turn.label if isinstance(turn, ir.Phase) else "tick" for turn in game.schedule]
    cells = {
        cell for shape in game.shapes if shape.directed for lane in shape.lanes for cell in lane
    }
    return Facts(
        numbers={n.name: n.value for n in (*game.sizes, *game.params)},
        own=tuple(action for action in game.agents.actions if action not in MOVES),
        schedule=" ".join(turns),
        shape=cells,
        walls_stop=frozenset(
            b.what for kind in game.kinds if kind.name == "wall" for b in kind.blocks
        ),
        seen=frozenset(s.field for s in game.observables if s.what == "own"),
        of_others=frozenset(s.field for s in game.observables if s.what in ("other", "everyone")),
        timers=frozenset(f.name for f in game.agents.fields if f.timer),
        relative=game.agents.relative,
        rows="" if game.rows == plain.rows else others[0],
    )


@pytest.mark.parametrize("name", NINE)
def test_default(name: str) -> None:
    game = game_of(name)
    assert game.agents.actions[: len(MOVES)] == MOVES
    assert (game.window.ahead, game.window.behind, game.window.left, game.window.right) == (
        9,
        1,
        5,
        5,
    )  # released code: 11 x 11
    assert facts_of(game, game)._asdict() == DEFAULT[name]._asdict()


@pytest.mark.parametrize(("name", "variant"), CHANGES, ids=lambda x: str(x))
def test_variant(name: str, variant: str) -> None:
    change = dict(CHANGES[name, variant])
    wanted = DEFAULT[name]
    numbers = {**wanted.numbers, **change.pop("numbers", {})}
    timers = wanted.timers | change.pop("timers", frozenset())
    found = facts_of(game_of(name, variant), game_of(name))
    assert found._asdict() == wanted._replace(numbers=numbers, timers=timers, **change)._asdict()


def test_no_variant_is_forgotten() -> None:
    found = {(name, variant) for name in NINE for variant in game_of(name).variants}
    assert found - set(CHANGES) == {
        (name, variant) for name in NINE if name.startswith("harvest") for variant in HARVEST_MAPS
    }


@pytest.mark.parametrize(("variant", "file"), HARVEST_MAPS.items())
def test_a_variant_that_is_a_map_equals_the_file(variant: str, file: str) -> None:
    """But for the name of the game and what is said about it."""
    by_variant, by_file = game_of("harvest_open", variant), game_of(file)
    assert by_variant.rows == by_file.rows
    assert facts_of(by_variant, by_variant) == facts_of(by_file, by_file)


def test_neighbours_of_harvest() -> None:
    """Decided: the 12 cells of the radius-2 disc, seen through walls."""
    (around,) = (shape for shape in game_of("harvest_open").shapes if not shape.directed)
    assert {cell for lane in around.lanes for cell in lane} == {
        (down, right) for down in range(-2, 3) for right in range(-2, 3) if 0 < abs(down) + abs(right) <= 2
    }  # fmt: skip
    assert around.see_through
