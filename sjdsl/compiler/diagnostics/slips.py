"""Habits from other languages and what to write instead, for syntax errors and unknown names."""

import re
from collections.abc import Collection, Iterator

ADD = "`add` adds to a field: `add 1 to agent.bag`, and `add -1 to agent.bag` takes from it"
BRACES = "a block is written in braces: `{ … }`"
CASE = "one of two values is chosen with `case`: `case agent.bag > 3 { yes: 1, no: 0 }`"
CHANCE = "`chance 0.5 { … }` happens with a probability, and `draw x from 1 .. 6` draws a number"
COMMENT = "a comment begins with `#`"
COMPARE = "numbers are compared with `==` and `!=`, words with `is` and `is not`"
CONDITIONS = "conditions are joined with `and` and `or`, and negated with `not`"
DEFINE = "`define` names an expression: `define rich(a) = a.bag > 3`"
DRAW = (
    "`draw n from 1 .. 6` draws a number evenly, `draw n from { 0: 0.75, 1: 0.25 }` with weights, "
    "and `pick 1 KIND { … }` a member"
)
EACH = (
    "`each` goes through all members of a sort: `each agent where agent.bag > 3 { … }`; "
    "there is no loop over numbers"
)
EXISTS = "`any(KIND where …)` asks whether there is one"
EXTENDS = (
    "nothing is imported, but a game can change another: "
    '`game mine "Mine" extends "other.sj" { … }`'
)
GOAL = "a goal stands without `choose`: `when agent.bag > 3 seek tree`"
IN = "after `in` stands a range, `1 .. 3`, or words in braces, `{ red, green }`"
OWNER = "functions have no owner: `round(x)`, `min(a, b)`, `abs(x)`"
OWN_FIELDS = (
    "fields are declared in the braces of their owner: `agents 2 { field bag : 0 .. 9 = 0 }`"
)
PHASES = (
    "rules stand in phases: `phase start` runs when an episode begins, "
    "and those of the schedule in each step"
)
POINT = "a number has digits on both sides of its point: `0.5`"
POWER = "a power is written `x ^ 2`, and a square root `sqrt(x)`"
RANGE = "a range is written `0 .. 5`, and words stand in braces, `{ happy, sad }`"
ROW = (
    "a list is a row, a value for each word or number: `field tokens by { red, blue } : 0 .. 9 = 0`"
)
SCHEDULE = "phases are joined with `->`: `schedule walk -> eat`"
SIDES = (
    "`disc(2)` means the cells within that distance; a window has four sides, "
    "`window ahead 9, behind 1, left 5, right 5`"
)
WHERE = "`where` keeps those for which a condition holds: `each agent where agent.bag > 3 { … }`"

# Patterns and their hints, by place: a word that can stand where the slip is, or nothing for any
# place. A pattern matches a word, or a statement from its first word on. One with ` ¦ ` matches
# the end of what was read, and what can't follow it. Words and signs have a space between each
# two. A hint that begins with a word is given where that word can stand; if the pattern matches
# one word, the hint's word is suggested in its place.
SLIPS = {
    "give": {
        r"\w+( \. \w+| \[ \w+ \])* ([+*/-] = .*|\+ \+.*|- -.*)": ADD,
        "(increment|decrement|increase|decrease|subtract|take|inc|dec) .*": ADD,
        r"\w+( \. \w+| \[ \w+ \])* (=|: =|< -) .*":
            "`set` writes a field: `set agent.bag = 1`; `let x = 1` names a value in this block",
        "(pay|reward|award) .*": "`give` rewards: `give 1 to agent`, `give -1 to agent`",
        "(ask|for) .*": EACH,
        r"(every|after|at|on) (step )?\d+ .*":
            "what happens at some steps has a condition: `when step == 10 { … }`, "
            "`when step % 10 == 0 { … }`",
        "(while|repeat|loop|until) .*":
            "there are no loops: the schedule runs once a step, "
            "and `each agent { … }` goes through all agents",
        "unless .*": "a negated condition is `when not agent.moved { … }`",
        "ifelse .*":
            "`when` begins a condition, and `otherwise` is the other case: "
            "`when c { … } otherwise { … }`",
        "(switch|case) .*":
            "`when a { … } otherwise when b { … }` chooses among statements, "
            "and `case` among values",
        "(print|log|echo)( .*)?":
            "nothing is printed: `tally eaten` counts an event, "
            "and `sjdsl trace` tells what happens in a step",
        "(pass|continue|skip|break|return)( .*)?":
            "no phase is left early: to do nothing write no statement, "
            "or guard the others with `when`",
        "(try|throw|raise|assert|error)( .*)?":
            "nothing fails in play: what must hold is tested, `checks { always count(agent) > 0 }`",
        "(forward|backward|fd|bk|back|walk|jump)( .*)?":
            "a rule moves an agent by `send`: `send agent by 1 ahead otherwise stay`",
        "(rt|lt|turn|rotate|face|turn_left|turn_right)( .*)?":
            "agents turn by their actions; a rule turns one that it sends: "
            "`send agent to grass facing north otherwise stay`",
        "(move_to|goto|teleport|respawn) .*":
            "`send` moves an agent by a rule: `send agent to grass otherwise stay`",
        "kill|destroy|delete|del|despawn|eliminate":
            "`remove` takes an agent or mover off the map for good: `remove agent`",
        "(die|dies)( .*)?": "`remove` takes an agent or mover off the map for good: `remove agent`",
        r"(spawn|create|hatch|sprout|clone)\w*( .*)?":
            "nothing is made in play: cells change, `set tree.fruit = ripe`, "
            "and agents come back, `send agent to grass after 5`",
        "one_of .*": "`pick` chooses members at random: `pick 1 tree { … }`",
        "(become|change|transform) .*":
            "a cell keeps its kind, and changes its fields: `set tree.fruit = none`",
        r"(emit|count|record) \w+ .*": "`tally` counts an event: `tally eaten`",
        "swap .*":
            "a phase reads the state before it, so two statements exchange values: "
            "`set a.bag = b.bag  set b.bag = a.bag`",
        "stop|done|win|lose|quit|exit|terminate": "`end` ends the episode after this step",
        "game over( .*)?": "the statement that ends an episode is `end`",
        "(wait|sleep|delay) .*":
            "a timer counts steps: declare `timer rest`, and write `set agent.rest = 3`",
        "tick( .*)?": "timers fall in a phase of the language: `schedule tick -> walk`",
        "(late|again|cancel|restart|undo)( .*)?":
            "the order is that of the schedule: a phase sees what the phases before it wrote",
        r"(right |left |up |down )?\[ .*":
            "`each` names who, and braces hold what happens: "
            "`each agent on tree { set tree.fruit = none }`",
        "(with )?(probability|prob|maybe) .*": CHANCE,
        "(def|function|func|lambda) .*":
            "a phase holds statements; a value is named outside the phases, "
            "`define rich(a) = a.bag > 3`",
        r"\w+ [.:] \w+( \. \w+)* \( .*":
            "there are no methods: statements such as `set`, `add`, "
            "`give` and `send` change what they name",
        "(include|import|using) .*": EXTENDS,
        "- - .*": COMMENT,
    },
    "kind": {
        r"(def|function|func) \w+ \( .* [:{] .*": DEFINE,
        "(include|import|using|from) .*": EXTENDS,
        "class|enum|struct|object|tile|terrain|patch":
            '`kind` declares a kind of cell: `kind lava "L"`',
        "monster|mover|npc|enemy|animal|breed":
            '`movers` are animals and things that rules move: `movers wolf 2 "w"`',
        "(globals|global|variables|state) .*":
            "fields of the world are declared one by one: `field total : 0 .. 9 = 0`",
        "(agents_own|turtles_own|patches_own|player) .*": OWN_FIELDS,
        "(turtles|patches) - .*": OWN_FIELDS,
        "legend .*": 'a kind is declared with its glyph: `kind lava "L"`',
        "(levels|level|world|board) .*": '`map` draws the map in rows: `map { "...." "TTTT" }`',
        r"(init|setup|reset|update|loop|step|rules?|turn|late|main)( \w+)? [{(:] .*": PHASES,
        r"to \w+ [\[{] .*": PHASES,
        "const|var|let|constant":
            "`param` declares a number of the game: `param apple : reward = 1`",
        r"number \w+ = .*": "`param` declares a number of the game: `param apple : reward = 1`",
        "event .*": "events are declared in `metrics { event eaten }`",
        "(horizon|max_steps|steps|length|duration) .*":
            "`episode` sets how many steps an episode has: `episode 100`",
        "(order|sequence|phases) .*": SCHEDULE,
        "(win|goal|terminate|end|done) .*":
            "a rule ends the episode: `phase rule { when step > 50 { end } }`",
    },
    "acts": {
        "(number|count|amount|players) .*":
            "the number of agents stands before the brace: `agents 3 { … }`",
    },
    "mean": {
        "(count|sum|min|max|avg|average|total|number) .*":
            "`mean` is taken over the steps, `final` at the end: `mean apples = count(tree)`",
        "(tally|reward|returns?) .*":
            "an event is declared here, `event eaten`, and counted by a rule, `tally eaten`",
    },
    "always": {
        "assert|invariant|ensure|check":
            "`always` states what holds after each step: `always count(agent) > 0`",
        "(never|eventually|sometimes) .*":
            "what never holds is written with `not`: `always not any(agent where agent.bag > 9)`",
    },
    "seek": {
        "choose (seek|aim) .*":
            "`seek` stands alone, without `choose`: `seek tree where tree.fruit is ripe`",
        "(goto|go|walk|move|approach|follow|chase) .*":
            "`seek` goes to the nearest member of a domain: `seek tree where tree.fruit is ripe`",
        "(choose|otherwise|else|stay)( .*)?":
            "rules are tried from the top, and an action has a condition, "
            "`when agent.bag > 3 choose stay`; an agent stays if none applies",
    },
    "choose": {
        "(do|then|take|:|->) .*": "`choose` names the action: `when agent.bag > 3 choose stay`",
        r"\{ .*": "a rule of a policy has no braces: `when agent.bag > 3 choose stay`",
    },
    "where": {"if|with|having|whose|who": WHERE, "such that .*": WHERE},
    "in": {
        "(near|around|beside|inside|within) [^{(].*":
            "`in` keeps those in a shape: `each tree in disc(2) of agent { … }`",
    },
    "on": {
        "(at|standing on) .*":
            "`on` joins an agent with the cell under it: `each agent on tree { … }`",
    },
    "{": {r", \{ .*": "no comma stands before a block", r"then|do|begin|:|\[|->|,": BRACES},
    "and": {
        "if [^{]* else .*": CASE,
        "but .*": CONDITIONS,
        "xor .*": "just one of two conditions is `(a or b) and not (a and b)`",
        "implies .*": "if a, then b is written `not a or b`",
    },
    "round": {  # where a function can stand
        "pow|power|square|root": POWER,
        "ln|log2|log10":
            "`log(x)` is the natural logarithm; to the base 2 it is `log(x) / log(2)`",
        "sigmoid|logistic|tanh|softmax":
            "`1 / (1 + exp(-x))` rises from 0 to 1",
        "sin|cos|tan":
            "there are no trigonometric functions: write a table, `case n { 0: 0, 1: 1, 2..: 0 }`",
        "floor|trunc":
            "`quotient(a, b)` divides whole numbers and rounds down, "
            "and `round(x)` rounds to the nearest",
        "ceil|ceiling":
            "`quotient(a + b - 1, b)` divides whole numbers and rounds up, "
            "and `round(x)` rounds to the nearest",
        "clamp|clip|constrain":
            "`min(max(x, 0), 3)` keeps a number between two others; "
            "a field that is `capped` stops at the ends of its range",
        "sign|sgn":
            "the sign of a number is `case x > 0 { yes: 1, no: case x < 0 { yes: -1, no: 0 } }`",
        "range":
            "there is no loop over numbers; to ask whether a number is in a range, "
            "write `agent.bag in 1 .. 3`",
        "normal|gauss|gaussian|poisson|uniform|choice|sample|shuffle": DRAW,
        "rand|random|randint|random_float|probability": CHANCE,
        "mod|modulo|rem": "the remainder is `a % b`",
        "div": "`quotient(a, b)` divides whole numbers and rounds down",
    },
    "step": {  # where a value can stand
        "rand|random|randint|random_float|probability": CHANCE,
        "pi|inf|infinity|maxint":
            "there is no such constant: write a number, `param pi : number = 3.1416`; "
            "a range has an end, `0 .. 9999`",
        "one|two|three": "numbers are written in digits: `pick 1 tree { … }`",
    },
    "": {
        # numbers and their signs
        r"\* ¦ \* .*": POWER,
        r"[²³√]": POWER,
        r"/ ¦ / .*":
            "`quotient(a, b)` divides whole numbers and rounds down; a comment begins with `#`",
        r"/ [/*] .*": COMMENT,
        "(mod|modulo|rem) .*": "the remainder is `a % b`",
        "div .*": "`quotient(a, b)` divides whole numbers and rounds down",
        r"([^\w\])]|give|add|chance|by|to) ¦ \. \d+ .*": POINT,
        r"\d+ ¦ \. .*": POINT,
        r"(give|add|chance|=) \d+ ¦ , \d+ .*": POINT,
        r"\d+ ¦ e\d* .*": "numbers are written without an exponent: `0.001`, `1000`",
        r"\d+ % ¦ .*": "a share is written as a number from 0 to 1: `0.5` for 50 percent",
        r"\d+ ¦ (\w+ \. \w+ (to|[-+*/<>=]+) .*|\( .*)":
            "a product is written with `*`: `2 * agent.bag`",
        "[≤≥≠×·÷−→⇒≔]":
            "operators are written in plain ASCII: `<=`, `>=`, `!=`, `*`, `/`, `-`, `->`, `=`",
        "∞": "a range has an end: `0 .. 9999`",
        # conditions
        r"[\w\])]+ (<|<=|>|>=|==) [\w .\[\]]+ ¦ (<|<=|>|>=|==) .*":
            "comparisons are joined with `and`: `10 < step and step < 20`",
        r"< ¦ > .*": COMPARE,
        r"(==|!=) ¦ = .*": COMPARE,
        "= [<>] .*": "the sign `=` comes last: `>=`, `<=`",
        "~ = .*": COMPARE,
        "isnt|equals?|eq|neq": COMPARE,
        r"is (greater|less|more|bigger|smaller|larger) ¦ .*":
            "numbers are compared with `<`, `<=`, `>`, `>=`, `==` and `!=`",
        "between .*": "to ask whether a number is in a range, write `agent.bag in 3 .. 5`",
        "& .*|! .*|[¬∧∨]": CONDITIONS,
        r"\| \| .*": CONDITIONS,
        r"\[ .* ¦ \| .*":
            "a rule says who and what: `each agent on tree { set tree.fruit = none }`",
        r"\| [^|]+ \| .*": "the absolute value is `abs(x)`",
        r"\w+ ¦ not (in|on|chose) .*":
            "the word `not` stands before the whole condition: `not agent on tree`, "
            "`not agent.bag in 1 .. 3`",
        r"(is|is not) ¦ (in|on) .*":
            "leave `is` out: `agent on tree`, `not agent on tree`, `agent.bag in 1 .. 3`",
        r"chose ¦ not .*": "the word `not` stands first: `not agent chose zap`",
        r"(did|does|chooses|picked) [a-z]\w* .*": "`chose` asks for an action: `agent chose zap`",
        r"in ¦ \d+ (cells?|tiles?) .*":
            "cells within a distance are a shape: `each tree in disc(3) of agent { … }`",
        r"in ¦ \[ .*": IN,
        r"in \( .* ¦ , .*": IN,
        r"in \{ ¦ \d+ .*": IN,
        "[∈∉⊂]": IN,
        "true|false|True|False": "conditions stand alone: `when c`, `when not c`",
        # values and their choice
        r"\?": CASE,
        r"sum \( [^()]* ¦ if .*":
            "`count(KIND where …)` counts those for which a condition holds",
        r"(give|=|by|chance) [^{}]* ¦ if .*": CASE,
        r"(is|not|=|==|!=|chose|\{|,|:) ¦ \"\w+\" .*":
            "words have no quotes: `tree.fruit is ripe`, `field mood : { happy, sad } = happy`",
        "[“”„«»‘’'`].*": 'text goes in double quotes, `"`',
        ";( .*)?": "statements need no `;` between them",
        "=": "`==` compares numbers, and `is` compares words",
        "==": "`=` stands between a name and its value, and `==` compares",
        r"(set|let) [^{}]* ¦ (: =|< -) .*": "the sign between a name and its value is `=`",
        r"set [^{}]* ¦ ([-+*/] =|\+ \+|- -) .*": "the statement that adds is `add 1 to agent.bag`",
        "null|nil|undefined|None": "no agent is written `nobody`, and no cell `nowhere`",
        "self|me|this|i":
            "an agent has the name that its statement gives it: `each agent as me { … }`",
        "Math( .*)?": OWNER,
        r"(random|math|np) \. \w+ ¦ \( .*": OWNER,
        # chance
        r"random ¦ \d+ .*": CHANCE,
        r"draw \w+ from \w+ \( .* ¦ .*": DRAW,
        r"draw \w+ from ¦ \[ .*": DRAW,
        r"draw \w+ ¦ (in|=|of) .*": "the word between is `from`: `draw n from 1 .. 6`",
        # domains
        "len|size_of|cardinality": "`count(KIND where …)` counts members",
        r"len \( .* ¦ .*": "`count(KIND where …)` counts members",
        r"(exists?|some) \( \w+ ¦ .*": EXISTS,
        "exists?|some|∃( .*)?": EXISTS,
        "∀.*":
            "`each agent { … }` goes through all agents; "
            "`all(tree where tree.fruit is ripe)` asks whether a condition holds for all",
        "[ΣΠ∑∏].*": "a sum is `sum(agent.bag over agent)`",
        r"\( [^()]* ¦ for .*":
            "`over` names the domain: `sum(a.bag over agent as a)`, `max(a.bag over agent as a)`",
        r"(any|all|count) \( \w+ ¦ \. .*":
            "a domain stands in `any`, `all` and `count`: `any(agent where agent.bag > 3)`",
        r"\w+ \( \w+ ¦ (where|on|as|in) .*":
            "a domain stands in `count(…)`, `any(…)` and `all(…)`, and after `over`, "
            "`sum(agent.bag over agent)`",
        r"(give|=|[-+*/(,<>]) (max|min|abs|round) ¦ \w+ [^(].*":
            "arguments stand in brackets: `max(a, b)`",
        "mean|average|avg":
            "write a sum divided by a count: `sum(e over KIND) / count(KIND)`, "
            "where the count is not 0",
        r"(neighbou?rs?|adjacent|nearby)( .*)?":
            "the cells around are a shape: `count(agent as other in disc(1) of agent)`",
        r"(neighbou?rs?|adjacent|nearby) ¦ .*":
            "the cells around are a shape: `count(agent as other in disc(1) of agent)`",
        r"agents \. .*": "how many agents there are is `count(agent)`",
        r"(each|first|over|in|when|where|\(|\d) ¦ agents .*":
            "write the singular: `each agent { … }`, `count(agent)`",
        r"pick [a-z]\w* ¦ (\{|where|as|on|in) .*": "how many comes first: `pick 1 tree { … }`",
        r"seek (nearest|closest|the|any) ¦ .*": "`seek` always goes to the nearest: `seek tree`",
        "foreach|forall|every|all":
            "`each` goes through all members of a sort: `each agent where agent.bag > 3 { … }`",
        # statements that begin as ours do
        "if": "`when` begins a condition: `when agent.bag > 3 { … }`",
        "(else if|elif|elseif|elsif) .*":
            "`otherwise` may have a condition: `otherwise when c { … }`",
        "else": "`otherwise` is the other case: `when c { … } otherwise { … }`",
        "def|function": DEFINE,
        "var|const|local":
            "`let` names a value in a block: `let x = 1`; "
            "numbers of the game are written `param x : reward = 1`",
        r"end ¦ (episode|game|if|for|while|each|when) .*":
            "the statement `end` stands alone, and ends the episode; a block ends with `}`",
        r"remove ¦ \d+ .*": "to take from a field, add to it: `add -1 to agent.bag`",
        r"give [a-z]\w* ¦ \d+ .*": "how much comes first: `give 1 to agent`",
        r"move ¦ (to|toward|forward|agent|\w+ to) .*":
            "a rule moves an agent with `send`, `send agent to grass`; "
            "`move each agent` does what the agents chose",
        # declarations that begin as ours do
        r"show \w+ \( \w+ ¦ [,.\[].*":
            "of the observer, a `define` is shown: `define way(a) = …`, `show way(agent)`",
        r"timer \w+ ¦ [:=] .*": "a timer begins at 0, and a rule starts it: `set agent.due = 5`",
        r"(param|size) \w+ ¦ = .*": "a number has a unit: `param apple : reward = 1`",
        r"field \w+ ¦ = .*": "a field has a type: `field score : 0 .. 9 = 0`",
        r"(param|size) [^{}]* = \S+ ¦ (\.\.|to) .*":
            "limits come after the value: `param apple : reward = 2 in 1 .. 3`",
        r"field \w+ : ¦ \[ .*": RANGE,
        r"field \w+ : \d+ - \d+ ¦ = .*": RANGE,
        r"field \w+ : \( .* ¦ , .*": RANGE,
        r"field \w+ : \w+ ¦ \{ .*": RANGE,
        r"let \w+ = ¦ [\[{] .*": ROW,
        r"define \w+( \( [\w ,]* \))? ¦ [:{] .*":
            "the expression comes after `=`: `define rich(a) = a.bag > 3`",
        r"kind \w+ \"[^\"]*\" ¦ (blocks|field|timer|glyph) .*":
            'the properties of a kind go in braces: `kind lava "L" { blocks agents }`',
        r"acts ¦ [=:\[{\"] .*": "list the actions right after `acts`: `acts stay, zap`",
        r"tally \w+ ¦ \+ .*": "the number to count comes after `by`: `tally eaten by 2`",
        r"field \w+ : \w+ = ¦ \[ .*": ROW,
        "list|array|dict|tuple|vector": ROW,
        "str|string|text|char":
            "a field holds one of its words, not a text: `field mood : { happy, sad } = happy`",
        "bool|boolean":
            "a field of two words is `field happy : { no, yes } = no`, "
            "and a number that is 0 or 1 is a `count in 0 .. 1`",
        "int|integer":
            "whole numbers have the unit `count`; a field of them is written with its range, "
            "`field bag : 0 .. 9 = 0`",
        "float|real|double":
            "real numbers have the unit `number` or `reward`; "
            "a field of them is `field earned : reward = 0`",
        r"kind \w+ ¦ = .*": 'the glyph follows the name: `kind lava "L"`',
        r"movers \w+ ¦ \".*": 'the number comes before the glyph: `movers wolf 3 "w"`',
        r"schedule [^{}]* ¦ (,|then|;|and) .*": SCHEDULE,
        r"schedule ¦ [\[({] .*": SCHEDULE,
        r"window ¦ (\d+|all|full) .*": SIDES,
        "radius|circle|vision|sight": SIDES,
        r"window [^{}]* \d+ ¦ (ahead|behind|left|right) .*":
            "sides are separated by commas: `window ahead 2, behind 1`",
        r"event \w+ ¦ = .*":
            "an event begins at 0 in each step, and a rule counts it: `tally eaten`",
        r"choose ¦ (seek|aim) .*": GOAL,
        # names of what there is
        "old|previous|prev":
            "`before` is for the value when the step began: `before(e)`, in `always` and `once`",
        "rewards?|score|payoff":
            "reward is given, not kept: `give 1 to agent`; to remember it, "
            "add it to a field of your own, `field earned : reward`",
        "direction|orientation|facing":
            "`heading` is the way an agent faces: `north`, `east`, `south` or `west`",
        "position|pos|location":
            "an agent's place is two numbers, `agent.row` and `agent.col`; "
            "`agent on KIND` asks what it stands on",
        "x|column": "`col` is the column, counted from 0 at the left",
        "y": "`row` is the row, counted from 0 at the top",
        "id": "`index` is the number of an agent, from 0",
        "action": "`agent chose zap` asks which action an agent chose",
        "time|t|timestep|ticks": "`step` is the number of finished steps of the episode",
    },
}  # fmt: skip


def slip(written: str, known: Collection[str], before: str = "") -> tuple[str, str]:
    """Returns the hint for what was written, and the word among `known` to write in its place.

    Both are empty where there is none. written: a name, or words and signs with a space between
    each two. before: those that it follows.
    """
    for pattern, hint in _patterns(known):
        # `LEFT ¦ RIGHT` applies only behind what matches LEFT.
        left, _, right = pattern.rpartition(" ¦ ")
        if not re.fullmatch(right, written):
            continue
        if left and not re.search(f"(^| )({left})$", before):
            continue
        # A hint that begins with a single word in backticks proposes it.
        word = hint.split("`")[1] if hint.startswith("`") else ""
        if not re.fullmatch("[a-z]+|=+", word):
            return hint, ""
        if word in known:
            return hint, word
    return "", ""


def _patterns(known: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yields the patterns for a place where words among `known` can stand, with their hints."""
    for place, hints in SLIPS.items():
        is_table = place == "{" and "nobody" in known  # a `{` in place of a value begins a table
        if not place or (place in known and not is_table):
            yield from hints.items()
