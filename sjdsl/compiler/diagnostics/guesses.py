"""Names that newcomers try, by the place where they try them, each with what to write instead."""

# Forms of shapes: `each tree in radius(2) of agent`.
_DISC = "`disc(r)` is all cells not farther than r, as the crow flies; `square(r)` and `diamond(r)` are the others without a direction"
_LINE = "`line(n)` is the n cells ahead; `fan(length, radius)` is wider"
SHAPES = {
    **dict.fromkeys(("radius", "circle", "around", "within", "near", "nearby", "range", "distance", "neighbours", "neighbors"), _DISC),
    **dict.fromkeys(("neighbourhood", "neighborhood", "ball"), _DISC),
    **dict.fromkeys(("ahead", "front", "infront", "facing", "beam", "ray", "forward"), _LINE),
    **dict.fromkeys(("box", "rect", "rectangle", "moore", "chebyshev"), "`square(r)` is all cells not more than r rows and r columns away"),
    **dict.fromkeys(("manhattan", "neumann"), "`diamond(r)` is all cells not more than r steps away"),
    **dict.fromkeys(("cone", "sector", "wedge"), "`fan(length, radius)` is a line of that length with `radius` lines on each side"),
}

# Functions: `when random() < 0.5`, `mean(a, b)`.
FUNCTIONS = {
    **dict.fromkeys(
        ("random", "rand", "uniform", "bernoulli"), "`chance 0.5 { … }` happens with a probability, `draw x from 1 .. 6` draws a number"
    ),
    **dict.fromkeys(("choice", "choose", "sample"), "`pick 1 KIND { … }` chooses a member, `draw x from { a, b }` a word"),
    **dict.fromkeys(("randint", "randrange"), "`draw x from 1 .. 6` draws a whole number, both ends included"),
    **dict.fromkeys(("exists", "some"), "`any(KIND where …)` says whether there is one"),
    **dict.fromkeys(("every", "forall", "each"), "`all(KIND where …)` says whether the condition holds for every one"),
    **dict.fromkeys(("none", "no"), "`not any(KIND where …)` says that there is none"),
    **dict.fromkeys(
        ("div", "floordiv", "floor", "int", "idiv"),
        "`quotient(a, b)` divides whole numbers and rounds down; `round(x)` rounds to the nearest",
    ),
    **dict.fromkeys(("old", "previous", "prev", "last"), "in `always` and `once`, `before(e)` is the value of e when the step began"),
    **dict.fromkeys(("len", "size", "number", "num"), "`count(KIND where …)` counts members"),
    **dict.fromkeys(
        ("mean", "average", "avg"), "write a sum divided by a count: `sum(e over KIND) / count(KIND)`, where the count is not 0"
    ),
    **dict.fromkeys(("clip", "clamp"), "`min(max(x, 0), 9)` keeps a number between two others"),
    **dict.fromkeys(("fabs", "absolute", "magnitude"), "`abs(x)` is x without its sign"),
    "if": "`case c { yes: 1, no: 0 }` is one value or the other",
}

# What is taken over a domain: `largest(agent.bag over agent)`.
OVER_DOMAINS = {
    **dict.fromkeys(("maximum", "largest", "greatest", "most", "highest", "top"), "`max(e over D otherwise v)` is the greatest value"),
    **dict.fromkeys(("minimum", "smallest", "least", "lowest", "nearest", "closest"), "`min(e over D otherwise v)` is the least value"),
}

# What agents and cells are asked for: `agent.x`, `agent.action`.
_REWARD = "reward is given, not kept: `give 1 to agent`; to remember it, add it to a field of your own, `field earned : reward`"
_TURNED = "`heading` is where an agent looks: `north`, `east`, `south` or `west`"
_CHOSE = "an action is asked for with `chose`: `agent chose stay`"
_PLACE = "where an agent is are two numbers, `agent.row` and `agent.col`; `agent on KIND` asks what it stands on"
AGENT_FIELDS = {
    **dict.fromkeys(("reward", "rewards", "score", "return", "points", "payoff", "utility"), _REWARD),
    **dict.fromkeys(("direction", "orientation", "facing", "dir", "angle", "rotation"), _TURNED),
    **dict.fromkeys(("action", "act", "move", "choice", "chose"), _CHOSE),
    **dict.fromkeys(("position", "pos", "location", "cell", "place", "tile"), _PLACE),
    **dict.fromkeys(("id", "number", "name", "num"), "`index` is the number of an agent, from 0"),
    **dict.fromkeys(("alive", "dead", "removed", "present", "active"), "`away` says whether an agent is away: `not agent.away`"),
}
PLACES = {
    **dict.fromkeys(("x", "column"), "`col` is the column, counted from 0 at the left"),
    "y": "`row` is the row, counted from 0 at the top",
}

# Units of numbers: `param speed : int = 1`.
UNITS = {
    **dict.fromkeys(("int", "integer", "num", "natural", "amount"), "`count` is the unit of whole numbers from 0"),
    **dict.fromkeys(
        ("float", "real", "double", "decimal"),
        "`number` is the unit of real numbers without one; others are a `reward`, a `probability` or a `fraction`",
    ),
    **dict.fromkeys(("payoff", "points", "score", "utility", "money", "cost"), "`reward` is the unit of what is given to agents"),
    **dict.fromkeys(("prob", "chance", "rate", "percent", "likelihood"), "`probability` is the unit of chances, from 0 to 1"),
    **dict.fromkeys(("time", "turns", "ticks", "seconds", "duration", "step"), "`steps` is the unit of durations"),
    **dict.fromkeys(("distance", "length", "radius", "cell", "tiles"), "`cells` is the unit of lengths"),
    **dict.fromkeys(("share", "ratio", "proportion"), "`fraction` is the unit of shares, from 0 to 1"),
    **dict.fromkeys(("bool", "boolean", "flag"), "a number that is 0 or 1 is a `count`, with the limits `in 0 .. 1`"),
    **dict.fromkeys(("string", "str", "text", "enum"), "`word` is the unit of words of the game"),
}

# Values: `give 1 to everyone`, `when time > 9`.
_ONESELF = "an agent is called as its statement names it: `each agent as me { … }`"
VALUES = {
    **dict.fromkeys(("everyone", "everybody", "anyone"), "`give e to all` reaches all agents; `each agent { … }` speaks of each"),
    **dict.fromkeys(
        ("others", "other", "neighbour", "neighbor"),
        "`give e to all but agent` reaches all others; `each agent as b where b is not agent { … }` speaks of each",
    ),
    **dict.fromkeys(("self", "me", "this", "myself", "i", "actor"), _ONESELF),
    **dict.fromkeys(
        ("reward", "rewards", "payoff", "score", "points", "utility"),
        "what is given is a number: `give 1 to agent`, or the name of one that the game declares, `param bonus : reward = 1`",
    ),
    **dict.fromkeys(("time", "t", "timestep", "now", "turn", "round", "tick"), "`step` is how many steps of the episode are finished"),
    **dict.fromkeys(("one", "a", "an", "random", "some", "any"), "a number of members is written with digits: `pick 1 tree { … }`"),
}

# Types of fields: `field happy : bool`.
_WORDS = "a field of two words is `field {name} : {{ false, true }} = false`, and is asked for with `is true`"
_WHOLE = "a field of whole numbers is written with its range: `field {name} : 0 .. 100 = 0`"
REAL_FIELD = "a field of real numbers is `field {name} : reward = 0`"
TYPES = {
    **dict.fromkeys(("bool", "boolean", "flag", "yes", "no", "condition"), _WORDS),
    **dict.fromkeys(("int", "integer", "number", "num", "count", "steps", "cells", "natural"), _WHOLE),
    **dict.fromkeys(("float", "real", "double", "probability", "fraction"), REAL_FIELD),
    **dict.fromkeys(("word", "enum", "string", "str", "text"), "a field of words lists them: `field {name} : {{ red, blue }} = red`"),
    **dict.fromkeys(
        ("agents", "player", "players"), "a field that holds an agent is `field {name} : agent`, one that holds several `set of agent`"
    ),
}

# Sides of the window: `window radius 5`.
_SIDES = "a window is given by its sides, as in `window ahead 9, behind 1, left 5, right 5`"
SIDES = dict.fromkeys(("radius", "size", "range", "width", "height", "square", "distance"), _SIDES)

# Frames of movement: `moves diagonal`.
MOVES = {
    **dict.fromkeys(
        ("absolute", "global", "map", "world", "cardinal", "grid"), "`moves compass` goes by the map: `forward` is one cell north"
    ),
    **dict.fromkeys(("egocentric", "local", "heading", "facing", "own"), "`moves relative` goes the way the agent faces"),
    **dict.fromkeys(
        ("diagonal", "diagonally", "eight", "any", "free", "all", "king"),
        "agents step to one of the four cells beside them: `moves relative` (as they face) or `moves compass` (as the map lies)",
    ),
}

# Actions that nothing looks at: `acts up, down, left, right`.
_STEPS = "{way} is built in as `{action}` with `moves compass`; with `moves relative` the steps go as the agent faces"
ACTIONS = {
    **dict.fromkeys(("up", "north", "move_up", "move_north"), _STEPS.format(way="a step north", action="forward")),
    **dict.fromkeys(("down", "south", "move_down", "move_south"), _STEPS.format(way="a step south", action="backward")),
    **dict.fromkeys(("left", "west", "move_left", "move_west"), _STEPS.format(way="a step west", action="step_left")),
    **dict.fromkeys(("right", "east", "move_right", "move_east"), _STEPS.format(way="a step east", action="step_right")),
    **dict.fromkeys(("rotate_left", "turn_l"), "a quarter turn is built in as `turn_left`"),
    **dict.fromkeys(("rotate_right", "turn_r"), "a quarter turn is built in as `turn_right`"),
    **dict.fromkeys(("noop", "no_op", "nothing", "wait", "idle", "none_"), "to do nothing is built in as `stay`, which every game has"),
}

# Conditions as values: `when agent.moved is true`.
CONDITIONS = ("true", "false", "yes", "no")

# Words of the language that are wanted as names, with names that can be had; for others the word with `_` behind it.
NAMES = {
    "agents": "players", "all": "everybody", "by": "maker", "chance": "luck", "chose": "choice", "count": "number", "end": "finish",
    "facing": "direction", "final": "last", "first": "leader", "for": "purpose", "from": "source", "give": "gift", "group": "team",
    "in": "inside", "kind": "sort", "map": "board", "mark": "sign", "match": "meeting", "mean": "average", "move": "motion", "of": "owner",
    "on": "upon", "over": "above", "phase": "stage", "pick": "picked", "schedule": "plan", "set": "setting", "shape": "form",
    "size": "extent", "sum": "total", "timer": "clock", "to": "target", "variant": "version", "window": "view", "with": "partner",
}  # fmt: skip
