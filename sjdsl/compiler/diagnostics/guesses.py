"""Names that newcomers try, by the place where they try them, each with what to write instead."""

from collections.abc import Mapping


def _by_word(rows: Mapping[str, str]) -> dict[str, str]:
    """Returns what to write instead of each word; a row may have several."""
    return {word: instead for words, instead in rows.items() for word in words.split()}


# Forms of shapes: `each tree in radius(2) of agent`.
_DISC = "`disc(r)` is all cells not farther than r, as the crow flies; `square(r)` and `diamond(r)` are the others without a direction"
_LINE = "`line(n)` is the n cells ahead; `fan(length, radius)` is wider"
SHAPES = _by_word({
    "radius circle around within near nearby range distance neighbours neighbors": _DISC,
    "neighbourhood neighborhood ball": _DISC,
    "ahead front infront facing beam ray forward": _LINE,
    "box rect rectangle moore chebyshev": "`square(r)` is all cells not more than r rows and r columns away",
    "manhattan neumann": "`diamond(r)` is all cells not more than r steps away",
    "cone sector wedge": "`fan(length, radius)` is a line of that length with `radius` lines on each side",
})  # fmt: skip

# Functions: `when random() < 0.5`, `mean(a, b)`.
FUNCTIONS = _by_word({
    "random rand uniform bernoulli": "`chance 0.5 { … }` happens with a probability, `draw x from 1 .. 6` draws a number",
    "choice choose sample": "`pick 1 KIND { … }` chooses a member, `draw x from { a, b }` a word",
    "randint randrange": "`draw x from 1 .. 6` draws a whole number, both ends included",
    "exists some": "`any(KIND where …)` says whether there is one",
    "every forall each": "`all(KIND where …)` says whether the condition holds for every one",
    "none no": "`not any(KIND where …)` says that there is none",
    "div floordiv floor int idiv": "`quotient(a, b)` divides whole numbers and rounds down; `round(x)` rounds to the nearest",
    "old previous prev last": "in `always` and `once`, `before(e)` is the value of e when the step began",
    "len size number num": "`count(KIND where …)` counts members",
    "mean average avg": "write a sum divided by a count: `sum(e over KIND) / count(KIND)`, where the count is not 0",
    "clip clamp": "`min(max(x, 0), 9)` keeps a number between two others",
    "fabs absolute magnitude": "`abs(x)` is x without its sign",
    "if": "`case c { yes: 1, no: 0 }` is one value or the other",
})  # fmt: skip

# What is taken over a domain: `largest(agent.bag over agent)`.
OVER_DOMAINS = _by_word({
    "maximum largest greatest most highest top": "`max(e over D otherwise v)` is the greatest value",
    "minimum smallest least lowest nearest closest": "`min(e over D otherwise v)` is the least value",
})  # fmt: skip

# What agents and cells are asked for: `agent.x`, `agent.action`.
_REWARD = "reward is given, not kept: `give 1 to agent`; to remember it, add it to a field of your own, `field earned : reward`"
_TURNED = "`heading` is where an agent looks: `north`, `east`, `south` or `west`"
_CHOSE = "`chose` tests an action: `agent chose stay`"
_PLACE = "where an agent is are two numbers, `agent.row` and `agent.col`; `agent on KIND` asks what it stands on"
AGENT_FIELDS = _by_word({
    "reward rewards score return points payoff utility": _REWARD,
    "direction orientation facing dir angle rotation": _TURNED,
    "action act move choice chose": _CHOSE,
    "position pos location cell place tile": _PLACE,
    "id number name num": "`index` is the number of an agent, from 0",
    "alive dead removed present active": "`away` says whether an agent is away: `not agent.away`",
})  # fmt: skip
PLACES = _by_word({
    "x column": "`col` is the column, counted from 0 at the left",
    "y": "`row` is the row, counted from 0 at the top",
})  # fmt: skip

# Units of numbers: `param speed : int = 1`.
UNITS = _by_word({
    "int integer num natural amount": "`count` is the unit of whole numbers from 0",
    "float real double decimal": "`number` is the unit of real numbers without one; others are a `reward`, a `probability` or a `fraction`",
    "payoff points score utility money cost": "`reward` is the unit of what is given to agents",
    "prob chance rate percent likelihood": "`probability` is the unit of chances, from 0 to 1",
    "time turns ticks seconds duration step": "`steps` is the unit of durations",
    "distance length radius cell tiles": "`cells` is the unit of lengths",
    "share ratio proportion": "`fraction` is the unit of shares, from 0 to 1",
    "bool boolean flag": "a number that is 0 or 1 is a `count`, with the limits `in 0 .. 1`",
    "string str text enum": "`word` is the unit of words of the game",
})  # fmt: skip

# Values: `give 1 to everyone`, `when time > 9`.
_ONESELF = "an agent is called as its statement names it: `each agent as me { … }`"
VALUES = _by_word({
    "everyone everybody anyone": "`give e to all` reaches all agents; `each agent { … }` goes through them",
    "others other neighbour neighbor": "`give e to all but agent` reaches all others; `each agent as b where b is not agent { … }` goes through them",
    "self me this myself i actor": _ONESELF,
    "reward rewards payoff score points utility": "what is given is a number: `give 1 to agent`, or the name of one that the game declares, `param bonus : reward = 1`",
    "time t timestep now turn round tick": "`step` is how many steps of the episode are finished",
    "one a an random some any": "a number of members is written with digits: `pick 1 tree { … }`",
})  # fmt: skip

# Types of fields: `field happy : bool`.
_WORDS = "a field of two words is `field {name} : {{ false, true }} = false`, and is tested with `is true`"
_WHOLE = "a field of whole numbers is written with its range: `field {name} : 0 .. 100 = 0`"
REAL_FIELD = "a field of real numbers is `field {name} : reward = 0`"
TYPES = _by_word({
    "bool boolean flag yes no condition": _WORDS,
    "int integer number num count steps cells natural": _WHOLE,
    "float real double probability fraction": REAL_FIELD,
    "word enum string str text": "a field of words lists them: `field {name} : {{ red, blue }} = red`",
    "agents player players": "a field that holds an agent is `field {name} : agent`, one that holds several `set of agent`",
})  # fmt: skip

# Sides of the window: `window radius 5`.
_SIDES = "a window is given by its sides, as in `window ahead 9, behind 1, left 5, right 5`"
SIDES = dict.fromkeys(("radius", "size", "range", "width", "height", "square", "distance"), _SIDES)

# Frames of movement: `moves diagonal`.
MOVES = _by_word({
    "absolute global map world cardinal grid": "`moves compass` goes by the map: `forward` is one cell north",
    "egocentric local heading facing own": "`moves relative` goes the way the agent faces",
    "diagonal diagonally eight any free all king": "agents step to one of the four cells beside them: `moves relative` (as they face) or `moves compass` (as the map lies)",
})  # fmt: skip

# Actions that nothing looks at: `acts up, down, left, right`.
_STEPS = "{way} is built in as `{action}` with `moves compass`; with `moves relative` the steps go as the agent faces"
ACTIONS = _by_word({
    "up north move_up move_north": _STEPS.format(way="a step north", action="forward"),
    "down south move_down move_south": _STEPS.format(way="a step south", action="backward"),
    "left west move_left move_west": _STEPS.format(way="a step west", action="step_left"),
    "right east move_right move_east": _STEPS.format(way="a step east", action="step_right"),
    "rotate_left turn_l": "a quarter turn is built in as `turn_left`",
    "rotate_right turn_r": "a quarter turn is built in as `turn_right`",
    "noop no_op nothing wait idle none_": "to do nothing is built in as `stay`, which every game has",
})  # fmt: skip

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
