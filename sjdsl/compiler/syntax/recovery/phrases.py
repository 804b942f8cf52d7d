"""Phrases that newcomers write for statements, declarations and expressions, and how to write them here.

In a pattern `PATH`, `EXPR`, `DOMAIN`, `NAME`, `INT`, `STRING` stand for such a part, `NAMES` and `TURNS` for several names; all else is
meant literally. In what stands instead, `{1}` is the first part, `{minus1}` it with the other sign, `{all1}` it in brackets if need be.
"""

import re
from collections.abc import Iterator, Mapping

from sjdsl.compiler.diagnostics.frozen import Record


class Phrase(Record):
    """`explanation`: what is said instead of "write …"."""

    pattern: tuple[str, ...]
    instead: str
    explanation: str = ""

    def write(self, parts: Mapping[str, str]) -> str:
        """Returns what stands instead, with the author's own parts."""
        lists = {"TURNS": " -> ", "NAMES": ", "}
        listed = [lists.get(element) for element in self.pattern if element.isupper()]
        own = dict(parts)
        for number, between in enumerate(listed, 1):
            if between is not None:
                own[str(number)] = between.join(names(parts[str(number)]))
        return self.instead.format(**{f"_{key}": text for key, text in own.items()})

    def explain(self, parts: Mapping[str, str]) -> str:
        """Returns what is said, with the author's own parts."""
        return self.explanation.format(**{f"_{key}": text for key, text in parts.items()})


def names(text: str) -> list[str]:
    """Returns the names of a list, with what stands in brackets behind them."""
    return [name for name in re.findall(r"\w+(?:\s*\([^)]*\))?", text) if name != "then"]


def _phrase(pattern: str, instead: str, explanation: str = "") -> Phrase:
    """Parts are numbered in the table, and named in templates."""
    return Phrase(tuple(pattern.split()), re.sub(r"\{(\w+)\}", r"{_\1}", instead), re.sub(r"\{(\w+)\}", r"{_\1}", explanation))


def _writes() -> Iterator[tuple[str, ...]]:
    """Reward and writes."""
    for word in ("reward", "pay", "award"):
        yield f"{word} PATH with EXPR", "give {2} to {1}"
        yield f"{word} PATH by EXPR", "give {2} to {1}"
        yield f"{word} PATH EXPR", "give {2} to {1}"
        yield f"{word} EXPR to PATH", "give {1} to {2}"
    for word in ("take", "deduct"):
        yield f"{word} EXPR from NAME . NAME", "add {minus1} to {2}.{3}"
        for amount in ("", " reward"):
            yield f"{word} EXPR{amount} from agent", "give {minus1} to agent"
    for word in ("fine", "punish", "penalise", "penalize", "charge"):
        for by in ("", " by", " with"):
            yield f"{word} PATH{by} EXPR", "give {minus2} to {1}"
    for everybody in ("agents", "all agents", "each agent", "every agent"):
        yield f"give EXPR to {everybody}", "give {1} to all"
    for others in ("all others", "the others", "other agents", "all other agents"):
        yield f"give EXPR to {others}", "give {1} to all but agent"
    yield "give PATH EXPR", "give {2} to {1}"
    yield "give EXPR", "give {1} to agent", "say to whom: `give {1} to agent`"
    for sign, value in (("=", "{2}"), ("+ =", "{2}"), ("- =", "{minus2}")):
        yield f"NAME . reward {sign} EXPR", f"give {value} to {{1}}"
    yield "PATH + = EXPR", "add {2} to {1}"
    yield "PATH - = EXPR", "add {minus2} to {1}"
    yield "PATH + +", "add 1 to {1}"
    yield "PATH - -", "add -1 to {1}"
    yield "set PATH to EXPR", "set {1} = {2}"
    yield "set PATH + = EXPR", "add {2} to {1}"
    yield "set PATH - = EXPR", "add {minus2} to {1}"
    written = "`set {1} = {2}` writes a field of the world, or in a variant a number; `let {1} = {2}` names a value in this block"
    yield "NAME = EXPR", "set {1} = {2}", written
    yield "PATH = EXPR", "set {1} = {2}"
    for word, sign in (("increment", ""), ("increase", ""), ("decrement", "-"), ("decrease", "-")):
        yield f"{word} PATH by EXPR", "add {minus2} to {1}" if sign else "add {2} to {1}"
        yield f"{word} PATH", f"add {sign}1 to {{1}}"
    yield "subtract EXPR from PATH", "add {minus1} to {2}"


def _places() -> Iterator[tuple[str, ...]]:
    """Places, repetition and conditions."""
    for word in ("put", "place", "spawn", "teleport", "move", "respawn", "send"):
        for where in ("at", "on", "in", "to", "onto"):
            if (word, where) != ("send", "to"):
                yield f"{word} PATH {where} DOMAIN", "send {1} to {2}"
    certain = "say which cell: `send {1} to KIND where KIND.row == {2} and KIND.col == {3}`, with a kind of cell for KIND"
    yield "send PATH to ( EXPR , EXPR )", "send {1} to grass", certain
    for word in ("kill", "delete", "destroy", "eliminate"):
        yield f"{word} PATH", "remove {1}"
    for word in ("for each", "for all", "for every", "forall"):
        yield f"{word} DOMAIN", "each {1}"
    yield "for NAME in agents", "each agent as {1}"
    yield "for NAME in NAME", "each {2} as {1}"
    yield "each DOMAIN , DOMAIN", "each {1}", "write one statement inside the other: `each {1} {{ each {2} {{ … }} }}`"
    for every in ("each", "every"):
        yield f"{every} EXPR steps", "when step % {1} == 0"
    yield "pick DOMAIN", "pick 1 {1}"
    for words in ("end episode", "end game", "end the episode", "end the game"):
        yield words, "end"
    yield "tick", "end", "`tick` stands in the schedule, among the phases: `schedule … -> tick`"
    for words in ("when chance", "if chance", "with probability", "with chance", "with prob", "probability", "prob"):
        yield f"{words} EXPR", "chance {1}"
    for words in ("else if", "elif", "elsif", "elseif"):
        yield f"{words} EXPR", "otherwise when {1}"
    yield "else", "otherwise"
    for word in ("else", "otherwise"):
        alone = (
            "`otherwise` follows `when`, `chance`, `pick` and `first`; after `each … where c {{ … }}` write `each … where not c {{ … }}`"
        )
        yield word, "each agent", alone
    for everybody in ("all agents", "every agent", "agents", "all", ""):
        yield f"move {everybody}", "move each agent"
    yield "agents", "agent"


def _expressions() -> Iterator[tuple[str, ...]]:
    """Places, comparisons, counting without brackets, and what cannot be had over a domain."""
    yield "PATH is on NAME", "{1} on {2}"
    yield "PATH on the NAME", "{1} on {2}"
    yield "chose NAME", "agent chose {1}"
    for near in ("near", "around", "close to"):
        yield f"{near} NAME", "in disc(1) of {1}"
    for beside in ("next to", "adjacent to", "beside"):
        yield f"{beside} NAME", "in diamond(1) of {1}"
    yield "within INT of NAME", "in disc({1}) of {2}"
    for word in ("radius", "distance", "range"):
        yield f"in {word} INT of NAME", "in disc({1}) of {2}"
    for less in ("<", "<="):
        for lesser in ("<", "<="):
            yield f"INT {less} PATH {lesser} INT", f"{{2}} {less.replace('<', '>')} {{1}} and {{2}} {lesser} {{3}}"
        for one in (">", ">="):
            yield f"PATH {one} INT and {less} INT", f"{{1}} {one} {{2}} and {{1}} {less} {{3}}"
    yield "count DOMAIN", "count({1})"
    yield "number of DOMAIN", "count({1})"
    yield "sum EXPR over DOMAIN", "sum({1} over {2})"
    yield "sum of EXPR over DOMAIN", "sum({1} over {2})"
    yield "sum EXPR", "sum({1})"
    for word in ("max", "min"):
        for of in ("", " of"):
            yield f"{word}{of} EXPR over DOMAIN", f"{word}({{1}} over {{2}})"


def _declarations() -> Iterator[tuple[str, ...]]:
    """Signs that declarations do not have, and lists with other signs between."""
    for word in ("episode", "episodes", "horizon", "max_steps", "episode_length"):
        for sign in (" =", " :", *[""] * (word != "episode")):
            yield f"{word}{sign} EXPR", "episode {1}"
    yield "episode EXPR steps", "episode {1}"
    for number in (4, 3, 2, 1):
        sides = ", ".join(f"{{{2 * i + 2}}} {{{2 * i + 1}}}" for i in range(number))
        yield "window " + " , ".join(["INT NAME"] * number), f"window {sides}"
        for sign in ("=", ":"):
            sides = ", ".join(f"{{{2 * i + 1}}} {{{2 * i + 2}}}" for i in range(number))
            yield "window " + " , ".join([f"NAME {sign} INT"] * number), f"window {sides}"
    for square in ("INT x INT", "INT , INT", "INT by INT", "INT", "= INT", "= INT x INT", "= INT , INT"):
        sides = "a window is given by its sides, as in `window ahead 9, behind 1, left 5, right 5`"
        yield f"window {square}", "window ahead {1}, behind {1}, left {1}, right {1}", sides
    for braces in ("TURNS", "= TURNS", ": TURNS", "{ TURNS }"):
        yield f"schedule {braces}", "schedule {1}"
    for word in ("view", "vision", "sight"):
        yield f"{word} INT", "window ahead {1}", "a window is given by its sides, as in `window ahead 9, behind 1, left 5, right 5`"
    yield "kind NAME STRING , NAME STRING", "kind {1} {2}  kind {3} {4}"
    yield "kind NAME", 'kind {1} "."', 'each kind has a glyph, the character that stands for it on the map: `kind {1} "."`'
    for solid in ("blocks", "solid", "blocking", "impassable", "blocked"):
        yield solid, "blocks agents"
    yield "agents NAME , NAME", "agents 2", "agents have numbers, not names: `agents 2 {{ … }}`; roles are kept in fields"
    for sign in ("=", ":"):
        yield f"agents {sign} EXPR", "agents {1}"
        yield f"moves {sign} NAME", "moves {1}"
        yield f"kind NAME {sign} STRING", "kind {1} {2}"
    for braces in ("= NAMES", ": NAMES", "{ NAMES }", "NAMES"):
        yield f"acts {braces}", "acts {1}"
        yield f"actions {braces}", "acts {1}"
    for number in (4, 3, 2):
        events = "  ".join(f"event {{{i + 1}}}" for i in range(number))
        yield "event " + " , ".join(["NAME"] * number), events
        yield "show " + " , ".join(["PATH"] * number), events.replace("event", "show")
    unit = "a number has a unit, `{word} {1} : reward = {2}`: count, steps, cells, reward, probability or fraction"
    for word in ("param", "size"):
        of = "reward" if word == "param" else "count"
        for sign in (" =", " :", ""):
            yield f"{word} NAME{sign} EXPR", f"{word} {{1}} : {of} = {{2}}", unit.replace("{word}", word).replace("reward =", f"{of} =")
    for sign in ("=", ":"):
        yield f"reward NAME {sign} EXPR", "param {1} : reward = {2}"
    for between in ("to", "-"):
        yield f"field NAME : INT {between} INT", "field {1} : {2} .. {3}"
    yield "field NAME : [ INT , INT ]", "field {1} : {2} .. {3}"
    typed = "a field has a type before its first value: a range `field {1} : 0 .. 9 = 0`, or words `field {1} : {{ red, blue }} = red`"
    yield "field NAME = EXPR", "field {1} : 0 .. 9 = {2}", typed
    whole = "a field of whole numbers is written with its range: `field {1} : 0 .. 100 = 0`"
    yield "field NAME : count = EXPR", "field {1} : 0 .. 100 = {2}", whole
    yield "field NAME : count", "field {1} : 0 .. 100 = 0", whole


def _checks() -> Iterator[tuple[str, ...]]:
    for each in ("each", "for each", "for all", "forall"):
        yield f"always {each} DOMAIN : EXPR", "always count({1}{and1} not {all2}) == 0"
    measured = "`mean {1} = {2}` is averaged over an episode, `final {1} = {2}` is its value at the end"
    for word in ("NAME", "sum NAME", "total NAME", "metric NAME", "mean NAME"):
        for sign in ("=", ":"):
            if (word, sign) != ("mean NAME", "="):
                yield f"{word} {sign} EXPR", "mean {1} = {2}", measured
    yield "total NAME", "event {1}", "`event {1}` counts what `tally {1}` reports; `mean` and `final` measure"
    yield "never EXPR", "always not {all1}"
    yield "always never EXPR", "always not {all1}"
    yield "eventually EXPR", "expect {1} with random over 30 episodes"


def _policies() -> Iterator[tuple[str, ...]]:
    """Rules of policies, and slots of scenarios."""
    for word in (
        "go to",
        "goto",
        "go towards",
        "go toward",
        "walk to",
        "move to",
        "head to",
        "approach",
        "chase",
        "follow",
        "find",
        "seek a",
    ):
        yield f"{word} DOMAIN", "seek {1}"
    for word in ("avoid", "but avoid", "not", "without", "except"):
        yield f"{word} DOMAIN", "avoiding {1}", "what is avoided stands behind what is sought: `seek … avoiding {1}`"
    always = "a choice has its condition, `when … choose {1}`; one that holds always is `when step >= 0 choose {1}`"
    for word in ("do", "act", "choose", "play", "take", "use"):
        if word != "choose":
            yield f"when EXPR {word} NAME", "when {1} choose {2}"
            yield f"aim NAME at DOMAIN {word} NAME", "aim {1} at {2} choose {3}"
        yield f"{word} NAME", "when step >= 0 choose {1}", always
        for at in ("at", "to"):
            yield f"{word} NAME {at} DOMAIN", "aim line(1) at {2} choose {1}", "say in which shape: `aim line(3) at {2} choose {1}`"
    sought = "`when` is followed by `choose`; what is sought has its condition behind `where`: `seek {2} where {1}`"
    yield "when EXPR seek DOMAIN", "seek {2}", sought
    yield "when EXPR aim NAME at DOMAIN choose NAME", "aim {2} at {3} choose {4}", sought.replace("seek {2}", "aim {2} at {3}")
    yield "when EXPR { NAME }", "when {1} choose {2}"
    yield "aim NAME at DOMAIN with NAME", "aim {1} at {2} choose {3}"
    yield "aim at DOMAIN with NAME", "aim line(3) at {1} choose {2}", "say in which shape: `aim line(3) at {1} choose {2}`"
    yield "aim at DOMAIN choose NAME", "aim line(3) at {1} choose {2}", "say in which shape: `aim line(3) at {1} choose {2}`"
    yield "otherwise seek DOMAIN", "seek {1}", "rules are tried in their order, and the first that applies acts: leave out `otherwise`"
    yield "otherwise NAME", "when step >= 0 choose {1}", "rules are tried in their order: as the last write `when step >= 0 choose {1}`"
    yield "slots EXPR NAME", "slots {1} policy {2}"
    yield "slots EXPR of NAME", "slots {1} policy {2}"
    yield "slots EXPR with NAME", "slots {1} policy {2}"
    yield "slots focal EXPR", "slots {1} focal"
    yield "slots NAME EXPR", "slots {2} policy {1}"


PHRASES = tuple(_phrase(*row) for table in (_writes, _places, _policies, _expressions, _declarations, _checks) for row in table())
