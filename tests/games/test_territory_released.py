"""The variant `socialjax` of Territory, scene by scene: touch, paint, zaps, and what pays. Source: the suite's released code."""

import pytest

from sjdsl.testing import Scene

from .environments import stage_of

ROWS = ("P.....#.", ".RR..R..", "........", "P.R.R..P")
STAGE = stage_of("territory", ROWS, 3, variant="socialjax")
LEFT, SECOND, RIGHT = (1, 1), (1, 2), (1, 5)
QUIET = 100


def put(*picture: str, **fields: object) -> Scene:
    return STAGE.put(
        *picture, fields={name.replace("_", ".", 1): value for name, value in fields.items()}
    )


def owned(by: int, quiet: int = 0, damage: int = 0) -> dict[str, object]:
    """Returns the fields of the brick `SECOND`, owned by an agent or by nobody."""
    return {
        "brick_owner": {SECOND: by},
        "brick_paint": {SECOND: "wet"},
        "brick_quiet": {SECOND: quiet},
        "brick_damage": {SECOND: damage},
    }


@pytest.mark.parametrize(("quiet", "paid"), [(0, 0), (98, 0), (99, 1), (100, 1)])
def test_a_brick_pays_a_hundredth_a_step_after_a_hundred_steps_in_peace(
    quiet: int, paid: int
) -> None:
    scene = put("v.....#.  0", ".RR..R..", "........", "P.R.R.<<  12", **owned(1, quiet))
    scene.step("stay, stay, stay").has({"reward": [0, 0.01 * paid, 0], "event paid": [0, paid, 0]})
    scene.step("stay, stay, stay").has({"reward": [0, 0.01 if quiet >= 98 else 0, 0]})


def test_touch_takes_over_at_once_and_leaves_the_peace() -> None:
    scene = put("P.v...#.  0", ".RR..R..", "........", "P.R.R.<<  12", **owned(1, QUIET))
    scene.step("stay, stay, stay").has(
        {"brick.owner": {SECOND: 0}, "reward": [0.01, 0, 0], "event claimed": [1, 0, 0]}
    )


def test_paint_reaches_two_cells_and_begins_the_peace_anew() -> None:
    scene = put("P.....#.", ".RR.<R..  0", "........", "P.R.R.<<  12", **owned(1, QUIET))
    scene.step("paint, stay, stay").has(
        {"brick.owner": {SECOND: 0}, "brick.quiet": {SECOND: 0}, "reward": 0}
    )
    mine = put("P.....#.", ".RR.<R..  0", "........", "P.R.R.<<  12", **owned(0, QUIET))
    mine.step("paint, stay, stay").has({"reward": [0.01, 0, 0]})


def test_a_zap_takes_what_is_owned_and_then_breaks_it() -> None:
    scene = put("P.....#.", ".RR.<R..  0", "........", "P.R.R.<<  12", **owned(1, QUIET))
    scene.step("zap, stay, stay").has(
        {"brick.owner": {SECOND: None}, "brick.damage": {SECOND: 1, LEFT: 0}, "reward": 0}
    )
    scene.step("paint, stay, stay").has({"brick.owner": {SECOND: None}})
    scene.step("zap, stay, stay").has({"brick.damage": {SECOND: 2}, "event blows": [1, 0, 0]})
    scene.step("zap, stay, stay").has({"brick.damage": {SECOND: 2}, "event blows": 0})
    free = put("P.....#.", ".RR.<R..  0", "........", "P.R.R.<<  12")
    free.step("zap, stay, stay").has({"brick.damage": {SECOND: 0}, "event blows": 0})


@pytest.mark.parametrize("damage", [1, 2])
def test_touch_mends(damage: int) -> None:
    scene = put(
        "P.v...#.  0", ".RR..R..", "........", "P.R.R.<<  12", brick_damage={SECOND: damage}
    )
    scene.step("stay, stay, stay").has({"brick.damage": {SECOND: 0}, "brick.owner": {SECOND: 0}})


@pytest.mark.parametrize(
    ("cell", "hit"),
    [((2, 2), True), ((2, 1), True), ((3, 1), False), ((1, 3), False), ((2, 3), False)],
)
def test_who_is_zapped_begins_anew_on_a_start(cell: tuple[int, int], hit: bool) -> None:
    """Agent 0 stands at (2, 3) and looks west: four cells, whatever is between."""
    rows = [list("P.....#."), list(".RR..R.."), list("...<...."), list("P.R.R..<")]
    if cell == (2, 3):
        return
    rows[cell[0]][cell[1]] = "^"
    numbers = {
        row: "".join(
            str(who)
            for _, who in sorted(
                [(3, 0)] * (row == 2) + [(cell[1], 1)] * (row == cell[0]) + [(7, 2)] * (row == 3)
            )
        )
        for row in range(4)
    }
    scene = put(
        *(f"{''.join(line)}  {numbers[number]}".rstrip() for number, line in enumerate(rows))
    )
    scene.step("zap, stay, stay").has({"event gone": [0, int(hit), 0]})
    assert (scene.places()[1] in ((0, 0), (3, 0), (3, 7))) == hit
