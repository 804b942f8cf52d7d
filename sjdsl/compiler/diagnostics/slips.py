"""What people write out of habit from other languages, and what to write instead: in syntax errors, and as unknown names."""

import re
from collections.abc import Collection

# Patterns of a word, or of a statement from its first word on; a hint that begins with a word is given where that word can stand.
SLIPS = {
    r"\w+( \. \w+| \[ \w+ \])* ([+-] = .*|\+ \+.*|- -.*)": "`add` adds to a field: `add 1 to agent.bag`, and `add -1 to agent.bag` takes from it",
    r"\w+( \. \w+| \[ \w+ \])* = .*": "`set` writes a field: `set agent.bag = 1`; `let x = 1` names a value in this block",
    "(pay|reward|award) .*": "`give` rewards: `give 1 to agent`, `give -1 to agent`",
    ";": "statements need no `;` between them",
    "[“”„«»‘’'`]": 'text goes in double quotes, `"`',
    r"(/|\*) .*": "a comment begins with `#`",
    "=": "`==` compares numbers, and `is` compares words",
    "==": "`=` stands between a name and its value, and `==` compares",
    "if": "`when` begins a condition: `when agent.bag > 3 { … }`",
    "(else if|elif) .*": "`otherwise` may have a condition: `otherwise when c { … }`",
    "else": "`otherwise` is the other case: `when c { … } otherwise { … }`",
    "for .*": "`each` goes through all members of a sort: `each agent where agent.bag > 3 { … }`; there is no loop over numbers",
    "foreach|forall": "`each` goes through all members of a sort: `each agent where agent.bag > 3 { … }`",
    "def|function": "`define` names an expression: `define rich(a) = a.bag > 3`",
    "var|const": "`let` names a value in a block: `let x = 1`; numbers of the game are written `param x : reward = 1`",
    "null": "no agent is written `nobody`, and no cell `nowhere`",
    "rand|random|randint|probability": "`chance 0.5 { … }` happens with a probability, and `draw x from 1 .. 6` draws a number",
    "len": "`count(KIND where …)` counts members",
    "exists|some": "`any(KIND where …)` asks whether there is one",
    "mean|average|avg": "write a sum divided by a count: `sum(e over KIND) / count(KIND)`, where the count is not 0",
    "old|previous|prev": "`before` is for the value when the step began: `before(e)`, in `always` and `once`",
    "radius|circle": "`disc(2)` means the cells within that distance; a window has four sides, `window ahead 9, behind 1, left 5, right 5`",
    "rewards?|score|payoff": "reward is given, not kept: `give 1 to agent`; to remember it, add it to a field of your own, `field earned : reward`",
    "direction|orientation|facing": "`heading` is the way an agent faces: `north`, `east`, `south` or `west`",
    "position|pos|location": "an agent's place is two numbers, `agent.row` and `agent.col`; `agent on KIND` asks what it stands on",
    "x|column": "`col` is the column, counted from 0 at the left",
    "y": "`row` is the row, counted from 0 at the top",
    "id": "`index` is the number of an agent, from 0",
    "action": "`agent chose zap` asks which action an agent chose",
    "time|t|timestep": "`step` is the number of finished steps of the episode",
    "self|me|this|i": "an agent has the name that its statement gives it: `each agent as me { … }`",
    "true|false": "conditions stand alone: `when c`, `when not c`",
    "bool|boolean": "a field of two words is `field happy : { no, yes } = no`, and a number that is 0 or 1 is a `count in 0 .. 1`",
    "int|integer": "whole numbers have the unit `count`; a field of them is written with its range, `field bag : 0 .. 9 = 0`",
    "float|real|double": "real numbers have the unit `number` or `reward`; a field of them is `field earned : reward = 0`",
}  # fmt: skip


def slip(written: str, known: Collection[str]) -> tuple[str, str]:
    """Returns the hint for what was written, and the word among `known` to write in its place; empty texts for none.

    written: a name, or words and signs with a space between each two.
    """
    for pattern, hint in SLIPS.items():
        if re.fullmatch(pattern, written):
            word = hint.split("`")[1] if hint.startswith("`") else ""
            if re.fullmatch("[a-z]+|=+", word):
                return (hint, word) if word in known else ("", "")
            return hint, ""
    return "", ""
