"""The two frames of movement, for any stage whose rows have room around a cell."""

from sjdsl.testing import Stage

ARROWS = "^>v<"
AROUND = ((-1, 0), (0, 1), (1, 0), (0, -1))  # north, east, south, west, as (rows, columns)
BY_HEADING = {
    "forward": 0,
    "step_right": 1,
    "backward": 2,
    "step_left": 3,
}  # quarter turns from the heading


def check_moves(stage: Stage, picture: tuple[str, ...], compass: bool) -> None:
    """Asserts where each move leads for each heading, that it does not turn, and how one turns.

    picture: agent 0 faces north where it can go to all four sides, the others are out of its way.
    """
    row, column = stage.put(*picture).places()[0] or (0, 0)
    for heading, arrow in enumerate(ARROWS):
        turned = (
            *picture[:row],
            picture[row][:column] + arrow + picture[row][column + 1 :],
            *picture[row + 1 :],
        )
        for action, quarter in BY_HEADING.items():
            rows, columns = AROUND[quarter if compass else (heading + quarter) % 4]
            scene = stage.put(*turned).step(action)
            assert scene.places()[0] == (row + rows, column + columns), (arrow, action)
            assert scene.headings()[0] == stage.put(*turned).headings()[0], (arrow, action)
        for action, quarters in (("turn_left", -1), ("turn_right", 1), ("stay", 0)):
            scene = stage.put(*turned).step(action)
            assert scene.places()[0] == (row, column), (arrow, action)
            assert scene.world.heading[0] == (heading + quarters) % 4, (arrow, action)
