"""Every mistake an author can make, in code order: SJ0xx syntax, 1xx names, 2xx types and units, 3xx maps, 4xx writes, 5xx time and use, 6xx limits of the compiler."""

from sjdsl.compiler.diagnostics.diagnostic import Code

# ---- 0xx the file and its syntax

NEWER_LANGUAGE = Code(
    "SJ001",
    "A file for another version of the language",
    "this file is for `sj {version}`, and this compiler reads `sj {known}`",
    "get a newer compiler, or write the file for `sj {known}`",
)
UNEXPECTED = Code("SJ002", "Something unexpected", "unexpected {found}, expected {expected}", "{help}")
RESERVED_WORD = Code(
    "SJ003",
    "A word of the language used as a name",
    "`{word}` is a word of the language and cannot be a name",
    "choose another name, such as `{other}`",
)
BAD_CHARACTER = Code("SJ004", "Not a character of the language", "character {character} is not part of the language", "{help}")
FILE_TOO_LARGE = Code(
    "SJ005",
    "A file too large",
    "the file has {given} bytes, and a game has at most {limit}",
    "is this the right file? a game is a few kilobytes of text",
)
TOO_DEEP = Code(
    "SJ006",
    "Nested too deeply",
    "this is nested deeper than {limit} levels",
    "give a part of it a name with `let` or `define`, or write it as a phase of its own",
)
TOO_MUCH = Code("SJ007", "More than the compiler takes", "{problem}; the most is {limit}", "{help}")
UNREADABLE = Code("SJ008", "A file that cannot be read", "`{name}` cannot be read: {problem}", "did you mean `{nearest}`?")
NOT_TEXT = Code("SJ009", "Not a text file", "this file is not text: {problem}", "a game is plain text in UTF-8; save it as such")
OPEN_STRING = Code("SJ010", "A text without its closing quote", "this text has no closing quote in its line", 'write `"` where it ends')
OPEN_BLOCK = Code("SJ011", "A block that is never closed", "this `{{` is never closed", "{help}")
NO_VERSION = Code("SJ012", "No version line", "the file does not begin with `sj {known}`{but}", "write `sj {known}` as the first line")

# ---- 1xx names

UNKNOWN_NAME = Code("SJ101", "Unknown name", "`{name}` is not known here", ("{help}", "did you mean `{nearest}`?", "{known}"))
NAME_TAKEN = Code("SJ102", "Name already taken", "`{name}` is already the name of {what}", "choose another name, or bind with `as`")
WORD_CLASH = Code("SJ103", "A word with the name of something else", "`{name}` is both a word and {what}", "rename one of the two")
NO_FIELD = Code("SJ104", "No such field", "{owner} has no field `{name}`", ("{help}", "did you mean `{nearest}`?", "{known}"))
NO_ACTION = Code("SJ105", "No such action", "`{name}` is not an action of the agents", ("did you mean `{nearest}`?", "{known}"))
PHASE_USE = Code("SJ106", "Phase and schedule disagree", "phase `{name}` is {problem}", "{help}")
NO_EVENT = Code(
    "SJ107",
    "Event not declared",
    "event `{name}` is not declared in `metrics`",
    ("write `event {name}` in `metrics`, or did you mean `{nearest}`?", "write `event {name}` in `metrics`"),
)
CHANGE_UNKNOWN = Code(
    "SJ108",
    "A change to what is not there",
    "this changes `{name}`, which the game does not have",
    ("did you mean `{nearest}`?", "{known}"),
)
CHANGE_CLASH = Code(
    "SJ109",
    "Two variants disagree",
    "variants `{first}` and `{second}` change `{name}` differently",
    "choose one of them",
)
EXTENDS_CYCLE = Code("SJ110", "A game that extends itself", "the chain of `extends` comes back to `{name}`", "break the circle")
NO_FILE = Code("SJ111", "Missing file", "there is no file `{name}` beside this game", "did you mean `{nearest}`?")
FILE_OUTSIDE = Code(
    "SJ112",
    "A path that leaves the folder",
    "`{name}` leaves the folder of the game",
    "name a file in the game's own folder or below it",
)
NOT_A = Code(
    "SJ113", "A name of another sort", "`{name}` is {what}, but {wanted} is wanted here", ("{help}", "did you mean `{nearest}`?", "{known}")
)
MISSING_PART = Code("SJ114", "Something every game needs", "the game has no {what}", "write {help}")
TWICE = Code("SJ115", "Said twice", "{what} is written twice", "keep one of them")
NO_VARIANT = Code("SJ116", "No such variant", "the game has no variant `{name}`", ("did you mean `{nearest}`?", "{known}"))
BAD_NAME = Code(
    "SJ117",
    "A name that cannot be used",
    "`{name}` cannot be used as {what}: {problem}",
    "choose another name",
)
ARGUMENTS = Code("SJ118", "Wrong number of arguments", "`{name}` takes {wanted}, not {given}", "{help}")
DEFINE_CYCLE = Code("SJ119", "A define that uses itself", "`{name}` is used inside its own definition", "break the circle")
NO_PAINT = Code(
    "SJ120",
    "No such sprite or colour",
    "`{name}` is no sprite and no colour",
    '{lead} sprites are {sprites}; the colours are {colours}, or any other as `"#rrggbb"`',
)

# ---- 2xx types and units

UNIT_MISMATCH = Code("SJ201", "Units that do not go together", "cannot {verb} {left} and {right}", "{help}")
PROBABILITY_RANGE = Code(
    "SJ202",
    "Not a probability",
    "this probability can {problem}",
    "keep it between 0 and 1, for instance with a range `in a .. b` on its parameters",
)
TABLE_GAP = Code("SJ203", "A table with a gap or an overlap", "{problem}", "every case exactly once")
FIELD_RANGE = Code(
    "SJ204",
    "A field can leave its range",
    "`{name}` can leave its range {low} .. {high} here: it can become {reached}",
    ("{help}", "write `capped` after the range, or guard the change with `when`"),
)
WORD_OUTSIDE = Code(
    "SJ205",
    "Not one of the words",
    "`{word}` is not one of the words of {name}",
    ("did you mean `{nearest}`? the words are {words}", "its words are {words}"),
)
NEVER_EQUAL = Code("SJ206", "These can never be equal", "these two can never be equal: they have no word in common", "")
ZERO_DIVISOR = Code(
    "SJ207",
    "Division by zero",
    "this divisor can be 0",
    "give the parameter a range that leaves out 0, or write a `require`",
)
EMPTY_MIX = Code("SJ208", "Shares of nothing", "this row can be empty, and then it has no shares", "guard it with `sum({row}) > 0`")
CAN_BE_NOBODY = Code("SJ209", "Nobody there", "`{path}` can be nobody here", "guard it with `{path} is not nobody`")
SHAPE_PARAM = Code(
    "SJ210",
    "A number that sets a shape",
    "`{name}` sets {what}, so it is a `size`, not a `param`",
    "write `size {name} : ...`",
)
WEIGHTS = Code("SJ211", "Weights that do not sum to 1", "the weights sum to {total}, not 1", "")
REQUIRE_FALSE = Code(
    "SJ212",
    "A requirement that does not hold",
    "this requirement does not hold: {problem}",
    "change the numbers, or the requirement",
)
WRONG_TYPE = Code("SJ213", "Something else is wanted here", "{wanted} is wanted here, and this is {given}", "{help}")
OUT_OF_LIMITS = Code("SJ214", "A number outside its limits", "{name} is {value}, outside {low} .. {high}{reason}", "")
CROSSED = Code(
    "SJ215",
    "Bounds that can cross",
    "the bounds {low} and {high} can cross",
    "write `require {low} <= {high}` in `checks`, or give the parameters ranges",
)
NOT_FIXED = Code("SJ216", "Not known when compiled", "{what} must be known when the game is compiled", "use numbers and `size`s only")

# What a condition around it can make right: said only where the conditions around could be read.
GUARDABLE = frozenset(
    {PROBABILITY_RANGE, TABLE_GAP, FIELD_RANGE, WORD_OUTSIDE, ZERO_DIVISOR, EMPTY_MIX, CAN_BE_NOBODY, WEIGHTS, CROSSED},
)

# ---- 3xx maps and shapes

UNKNOWN_GLYPH = Code(
    "SJ301",
    "Unknown map glyph",
    "glyph `{glyph}` at row {row}, column {column} is in no kind",
    ("declare it with `kind` or `glyph`, or did you mean `{nearest}`?", 'declare it, as in `kind NAME "{glyph}"`'),
)
RAGGED_MAP = Code("SJ302", "Rows of different length", "row {row} has {length} characters, the others {wanted}", "")
TOO_FEW_CELLS = Code(
    "SJ303",
    "Too few cells",
    "`{kind}` has {cells} for {agents} agents",
    "enlarge the map, or lower the number of agents",
)
GLYPH_TWICE = Code(
    "SJ304",
    "A glyph of two kinds",
    "glyph `{glyph}` belongs to `{first}` and to `{second}`",
    "give one of them another glyph",
)
BAD_PICTURE = Code(
    "SJ305",
    "A picture that shows no shape",
    "{problem}",
    "a picture has exactly one `^` (the agent, facing up); its cells are `x`, all else `.`",
)
KIND_ABSENT = Code("SJ306", "A kind that is not on the map", "kind `{name}` never appears on the map", "", "warning")
EMPTY_MAP = Code("SJ307", "A map without cells", "the map has no cells", "")
BAD_GLYPH = Code("SJ308", "Not a glyph", "`{glyph}` cannot be a glyph: {problem}", "a glyph is one printable ASCII character")
MAP_FILE = Code(
    "SJ309",
    "A map that cannot be read",
    "the map `{name}` cannot be read: {problem}",
    "a map is plain text, one line a row",
)
DIRECTED_SHAPE = Code(
    "SJ310",
    "A shape that needs a heading",
    "`{name}` needs an agent's heading, and `{anchor}` is a cell",
    "use `disc`, `diamond` or `square` around cells",
)

# ---- 4xx writes

WRITE_CONFLICT = Code(
    "SJ401",
    "Two writes in one phase",
    "`{name}` of one {owner} can be written twice in phase `{phase}`",
    (
        "{accepted}",
        "write two phases; or pair them with `match`; or collect into a `set of agent` and `pick 1` from it in the next phase; or use `add`",
    ),
)
ADD_AND_SET = Code(
    "SJ402",
    "Set and add in one phase",
    "`{name}` is both set and added to in phase `{phase}`",
    ("{accepted}", "write two phases, or make the two exclude each other"),
)
TWO_DESTINATIONS = Code(
    "SJ403",
    "Two destinations",
    "an agent can be sent to two places in phase `{phase}`",
    ("{accepted}", "make the two exclude each other, or send to one place"),
)
NO_FREE_CELL = Code(
    "SJ404",
    "There may be no free cell",
    "{problem}",
    "{help}",
)
MOVE_ALONE = Code(
    "SJ405",
    "Movement shares its phase",
    "`move` stands alone in its phase",
    "put the other sentences into a phase of their own",
)
OVERLAPPING_SENDS = Code(
    "SJ406",
    "Two destinations that overlap",
    "two different destinations of one phase share cells of `{kind}`",
    "send to one destination, or write two phases",
)

# ---- 5xx time and use

NO_START = Code("SJ501", "Agents without a place", "{problem}", "write `phase start {{ each agent {{ send agent to KIND }} }}`")
TICK = Code("SJ502", "The schedule and its timers", "{problem}", "{help}")
TIMER_BOTH_SIDES = Code(
    "SJ503",
    "A timer set on both sides of `tick`",
    "timer `{name}` is set before and after `tick`",
    "set it on one side, or it lasts one step less on the other",
    "warning",
)
NEVER_HAPPENS = Code("SJ504", "This can never happen", "this can never happen: {problem}", "", "warning")
UNUSED = Code("SJ505", "Never used", "{what} `{name}` is never used", "", "warning")
IDLE_ACTION = Code("SJ506", "An action without effect", "{problem}", "{help}", "warning")
FORBID_READS = Code(
    "SJ507",
    "What `forbid` may read",
    "`forbid` reads {what}",
    "it may read the acting agent's own fields and the world's",
)
NO_PLACE_YET = Code(
    "SJ508",
    "No place yet",
    "in `phase start` no agent has a place yet, so `{what}` means nothing",
    "do it in a phase of the schedule, at `step == 0`",
)

NEVER_COUNTED = Code(
    "SJ509",
    "An event that is never counted",
    "the event `{name}` is listed in `metrics`, but no rule counts it: it is always 0",
    "count it where it happens, `tally {path}`, or take it out of `metrics`",
    "warning",
)
LOOK_READS = Code(
    "SJ510",
    "What `look` may read",
    "`look` reads {what}",
    "it may compare the fields of the cell, or of the agent, with words and numbers",
)

# ---- 6xx limits of the compiler

NOT_SUPPORTED = Code("SJ601", "Not supported yet", "not supported yet: {what}", "{help}")
