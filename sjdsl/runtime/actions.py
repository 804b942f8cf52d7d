"""Headings and the built-in actions of agents: compass, turns and steps, for everybody but the interpreter, which has its own."""

HEADINGS = ("north", "east", "south", "west")  # a heading is a number, 0 to 3
DIRECTIONS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # rows and columns of a step with each heading
TURNS = {"turn_left": 3, "turn_right": 1}  # quarter turns to the right
STEPS = {
    "forward": 0,
    "step_right": 1,
    "backward": 2,
    "step_left": 3,
}  # directions: from the heading, or of the compass
MOVES = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward")
BUILT_IN = (*MOVES, "stay")
ANY_HEADING, SAME_HEADING = (
    4,
    5,
)  # of somebody who is away, in place of the heading it will have: one that is drawn, or the one it had
