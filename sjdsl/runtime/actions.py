"""Headings and the built-in actions of agents; the interpreter has its own."""

HEADINGS = ("north", "east", "south", "west")  # a heading is a number, 0 to 3
DIRECTIONS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # rows and columns of a step with each heading
TURNS = {"turn_left": 3, "turn_right": 1}  # quarter turns to the right
# Directions, from the heading or of the compass.
STEPS = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}
MOVES = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward")
BUILT_IN = (*MOVES, "stay")
# In place of the heading that somebody who is away will have: a drawn one, or the one it had.
ANY_HEADING = 4
SAME_HEADING = 5
