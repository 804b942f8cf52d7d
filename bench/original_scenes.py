"""Scenes of Melting Pot itself on small maps, with scripted players: what follows a zap, a meeting, a shot, a cube, a bite.

Each returns figures as bench/meltingpot_figures.py writes them: numbers of steps after that of the cause, if nothing else is said.
"""

from typing import Any

from original_play import BACK, EAST, FORWARD, NORTH, SOUTH, TURN, WAIT, WEST, Play, pair

ZAP, INTERACT, GRASP, TAG = {"fireZap": 1}, {"interact": 1}, {"grasp": 1}, {"tag": 1}
Figures = dict[str, Any]


def set_parts(settings: Any, component: str, **values: Any) -> int:
    """Changes the settings of every part of a kind, wherever it is; returns how many there are."""
    if isinstance(settings, list | tuple):
        return sum(set_parts(entry, component, **values) for entry in settings)
    if not hasattr(settings, "items"):
        return 0
    here = settings.get("component") == component
    if here:
        settings["kwargs"].update(values)
    return here + sum(set_parts(entry, component, **values) for _, entry in settings.items())


ROOMS = {
    "territory__open": [",P,P,,"],
    "allelopathic_harvest__open": ["WWWWWWWWWW", "WPPWWWWWWW", "WWWWWWWWWW"],
    "externality_mushrooms__dense": ["__________", "!  |", "----------"],
}


def zaps() -> Figures:
    """Returns what happens to who is zapped: when it can move and zap again, until when a second zap counts, when it is back."""
    return {name: after_a_zap(name) for name in ROOMS}


def after_a_zap(name: str) -> Figures:
    """Returns the figures of one substrate; `back` only where a second zap does not remove for good."""

    def zapped() -> Play:
        return pair(name, ROOMS[name]).step(ZAP)

    play = zapped()
    before = play.heading(1)
    found = {"moves": play.steps_until(lambda p: p.heading(1) != before, WAIT, TURN)}
    found["zaps"] = zapped().steps_until(lambda p: "zap" in p.events(), WAIT, ZAP)
    counts = [n for n in range(30, 60) if "removal_due_to_sanctioning" in zapped().rest(n - 1).step(ZAP).events()]
    found["second_zap_counts_until"] = max(counts)
    if name != "territory__open":
        gone = zapped().rest(9).step(ZAP).rest(3)
        empty = gone.world()
        found["back"] = 3 + gone.steps_until(lambda p: p.world() != empty)
    return found


def sowing() -> int:
    """Returns how many steps after sowing a colour the same one can be sown again. Another colour can after one to three, by chance."""
    rows = ["W" * 10, "WPFFWWWWWW", "W" * 10]
    play = Play("allelopathic_harvest__open", rows, ["default"], {"F": "floor"}).face(EAST)
    col, row = play.place(0)
    bare = play.cell(col + 1, row)
    play.step({"fire_1": 1}).step()
    play.steps_until(lambda p: p.cell(col + 1, row) != bare, {"fire_1": 1})
    return play.steps_until(lambda p: p.cell(col + 1, row) != bare, {"fire_1": 1})


def drying() -> int:
    """Returns how many steps after a claim a brick of Territory pays first."""

    def surely(settings: Any) -> None:
        set_parts(settings, "Resource", rewardRate=1.0)

    while True:
        play = Play("territory__open", ["PR,,,,"], ["default"], change=surely)
        play.face(SOUTH)
        if not play.rest(40).reward(0):
            play.step({"turn": -1})  # it touches the brick
            return play.steps_until(lambda p: p.reward(0) > 0)


MEETINGS = {
    "prisoners_dilemma_in_the_matrix__arena": "WP11PW",
    "prisoners_dilemma_in_the_matrix__repeated": "Wn11nW",
    "running_with_scissors_in_the_matrix__repeated": "WnrpnW",
    "running_with_scissors_in_the_matrix__one_shot": "WnrpnW",
}


def meetings() -> Figures:
    """Returns what follows a meeting in the matrix: inventories shown, reward, return, regrowth, the end of one_shot."""
    found: Figures = {}

    def bare(settings: Any) -> None:
        set_parts(settings, "Resource", regenerationDelay=1000)

    for name, row in MEETINGS.items():
        rows = ["W" * 6, row, "W" * 6]
        play = pair(name, rows, change=bare).step(FORWARD, FORWARD)
        shown = play.step(INTERACT).told("INTERACTION_INVENTORIES")
        found[name] = here = {"shown": shown, "shown_later": play.step().told("INTERACTION_INVENTORIES")}
        here["reward"] = 1 + play.steps_until(lambda p: p.reward(0) != 0)
        if name.endswith("one_shot"):
            here["end"] = here["reward"] + play.steps_until(lambda p: p.seen.last())
            continue
        empty = play.rest(1).world()
        here["back"] = here["reward"] + 1 + play.steps_until(lambda p, empty=empty: p.world() != empty)
        here["regrowth"] = regrowth(name, rows)
    return found


def regrowth(name: str, rows: list[str]) -> int:
    """Returns how many steps after it was collected a resource is back if it comes as soon as it may."""

    def surely(settings: Any) -> None:
        set_parts(settings, "Resource", regenerationRate=1.0)

    play = pair(name, [rows[0] + "W", rows[1][:4] + " " + rows[1][4:], rows[2] + "W"], change=surely)
    play.step(FORWARD).step(BACK)
    col, row = play.place(0)
    bare = play.cell(col + 1, row)
    return 1 + play.steps_until(lambda p: p.cell(col + 1, row) != bare)


CREW = [*["crewmate"] * 4, "impostor"]
ROOM = [
    "*xxxxxxxxxxxxxxVVVVVV",
    "xxxxxxxxxxxxxxxVVVVVV",
    "xxxxxxxxxxxxxxxxxxxxx",
    "*xxxxxxxxxxxxxxxDDDDD",
    "=xxxxxxxxxxxxxxxxxxxx",
    "***xxxxxxxxxxxxxxxxxx",
]


def hidden_agenda() -> Figures:
    """Returns when the first shot is possible and the next one, when a vote begins, and how many ballots it takes, if a shot calls it too."""
    play = Play("hidden_agenda", ROOM, CREW)
    found = {"first_shot": play.steps_until(lambda p: "tag" in p.events(), *[WAIT] * 4, TAG)}
    play = Play("hidden_agenda", ROOM, CREW)
    found["vote_begins"] = play.steps_until(lambda p: "vote_round" in p.events())
    found["ballots"] = ballots(play)
    found["next_vote"] = play.steps_until(lambda p: "vote_round" in p.events())
    found |= shot_that_calls()
    return found


def ballots(play: Play, voter: int = 0) -> int:
    """Returns in how many steps a vote can be cast or changed."""
    steps = 0
    while "vote" in play.step(*[WAIT] * voter, {"vote": 1 + steps % 2}).events():
        steps += 1
    return steps


def shot_that_calls() -> Figures:
    """Returns how many ballots a vote takes that a shot has called, and how many players it carries to the room, its victims among them."""
    while True:
        play = Play("hidden_agenda", ROOM, CREW).rest(50)
        while play.heading(4) != WEST:
            play.step(*[WAIT] * 4, TURN)
        happened = play.step(*[WAIT] * 4, TAG).events()
        if "vote_round" in happened and "tagHit" in happened:
            break
        play.env.close()
    carried = sum(play.place(i)[0] >= ROOM[0].index("V") for i in range(5))
    voter = next(i for i in range(4) if not play.told("VOTING")[i][-1])  # the last column: who is out
    return {"ballots_after_a_shot": ballots(play, voter), "carried": carried}


def boat_race() -> Figures:
    """Returns the steps of the lights, the one in which a race ends, and the period of races."""
    play = Play("boat_race__eight_races", change=lambda s: set_parts(s, "EpisodeManager", checkInterval=100_000) and None, places=False)
    starts, ends_, changed, light = [], [], [], play.cell(7, 9)
    while len(ends_) < 2:
        happened = play.step().events()
        if play.cell(7, 9) != light:
            light = play.cell(7, 9)
            changed.append(play.now)
        if "race_start" in happened:
            starts.append(play.now)
        if "player_disqualified" in happened:
            ends_.append(play.now)
    return {"yellow": changed[0], "green": changed[1], "red": ends_[0], "period": starts[1] - starts[0]}


MACHINES = {
    "F": {"type": "all", "list": ["tiled_floor", "apple"]},
    "K": {"type": "all", "list": ["tiled_floor", "blue_cube_wait"]},
    "P": {"type": "all", "list": ["tiled_floor", "apple", "spawn_point"]},
    "C": {"type": "all", "list": ["tiled_floor", "blue_cube_wait", "blue_cube_live"]},
}
FEEDINGS = (  # machines, s: a cube and an apple, t: two apples; the steps in which they are fed
    ("s", (10,)), ("t", (10,)), ("ss", (10, 15)), ("ss", (10, 26)), ("ss", (10, 27)), ("sss", (10, 15, 100)), ("sts", (10, 15, 100)),
    ("stst", (10, 15, 100, 160)), ("stts", (10, 15, 100, 105)), ("sts", (10, 15, 30)), ("ss", (10, 20)), ("ss", (10, 21)), ("tt", (10, 20)), ("tt", (10, 21)),
)  # fmt: skip


def machines() -> list[Figures]:
    """Returns what machines give that are fed at these steps: the steps in which it lies on each of the two outlets, 0 for nothing."""
    return [{"machines": sorts, "fed": list(fed), "gives": outlets(sorts, fed)} for sorts, fed in FEEDINGS]


def outlets(sorts: str, fed: tuple[int, ...]) -> list[list[int]]:
    rows = [
        "".join(part) for part in zip(*[("FFl" + s, "FFO" + {"s": "j", "t": "#"}[s], "FFCz", "FFPx", "FKKF") for s in sorts], strict=True)
    ]
    play = Play("factory_commons__either_or", [row + "F" for row in rows], ["default"] * len(sorts), MACHINES)
    play.face(*[NORTH] * len(sorts))
    player = {play.place(i)[0] // 4: i for i in range(len(sorts))}
    places = [(machine, row) for machine in range(len(sorts)) for row in (2, 3)]
    bare = {(m, row): play.cell(4 * m + 3, row) for m, row in places}
    given, seen = dict.fromkeys(places, 0), dict(bare)
    for step in range(1, max(fed) + 60):
        actions = [WAIT] * len(sorts)
        for machine, at in enumerate(fed):  # it takes the cube before it, carries it to the mouth and lets go
            actions[player[machine]] = {at - 2: GRASP, at - 1: FORWARD, at: GRASP}.get(step, WAIT)
        play.step(*actions)
        for m, row in places:
            if play.cell(4 * m + 3, row) != seen[m, row]:  # first it flies, then it lies
                seen[m, row], given[m, row] = play.cell(4 * m + 3, row), step
    return [[given[m, row] * (seen[m, row] != bare[m, row]) for row in (2, 3)] for m in range(len(sorts))]


def predators() -> Figures:
    """Returns what two predators earn that bite one prey at once, and when the prey is back."""
    rows = ["~" * 7, "!XYX''|", "~" * 7]
    play = Play("predator_prey__open", rows, ["predator", "predator", "prey"], STARTS)
    play.face(*((EAST, WEST) if play.place(0)[0] < play.place(1)[0] else (WEST, EAST))).rest(5).step(INTERACT, INTERACT)
    found: Figures = {"paid": [play.reward(0), play.reward(1)]}
    empty = play.rest(8).world()
    found["back"] = 8 + play.steps_until(lambda p: p.world() != empty)
    return found | eating() | held()


STARTS = {
    letter: {"type": "all", "list": ["tiled_floor", f"spawn_point_{role}"]} for letter, role in {"X": "predator", "Y": "prey"}.items()
}


def eating() -> Figures:
    """Returns the steps after sitting down in which prey that walks on moves, and those in which a third of the acorn is paid."""
    play = Play("predator_prey__open", ["~" * 12, "!YA''''''''|", "~" * 12], ["prey"], STARTS)
    play.face(EAST).rest(2).step(FORWARD).rest(9).step(INTERACT)
    moved, paid = [], []
    for after in range(1, 28):
        where = play.place(0)
        play.step(FORWARD if after <= 7 else WAIT)
        moved += [after] * (play.place(0) != where)
        paid += [after] * (play.reward(0) > 0)
    return {"walks_while_eating": moved, "acorn_pays": paid}


def held() -> Figures:
    """Returns the stamina of a predator before and after each of six steps from its bite on, in which it tries to walk."""
    play = Play("predator_prey__open", ["~" * 9, "!XY'''''|", "~" * 9], ["predator", "prey"], STARTS)
    play.face(EAST).rest(5).step(INTERACT)
    stamina = [round(18 * play.told("STAMINA"))]
    for _ in range(6):
        stamina.append(round(18 * play.step(BACK).told("STAMINA")))
    return {"stamina_from_the_bite": stamina}


def paintball() -> int:
    """Returns how many steps after it was shot down a player of Paintball is back: its cell then shows more than paint."""
    play = Play("paintball__capture_the_flag", ["W" * 9, "WPQ,,,,,W", "WFWWWWWGW", "W" * 9], ["default"] * 2)
    red, blue = sorted((0, 1), key=lambda i: play.place(i)[0])
    play.face(*([EAST, WEST] if red == 0 else [WEST, EAST]))
    col, row = play.place(blue)
    while len(set(play.cell(col, row))) > 3:
        play.step(*[ZAP if i == red else WAIT for i in (0, 1)]).rest(2)
    paint = play.cell(col, row)
    return 2 + play.steps_until(lambda p: p.cell(col, row) != paint)
