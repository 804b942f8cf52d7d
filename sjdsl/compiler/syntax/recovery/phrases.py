"""Phrases that newcomers write for statements, declarations and expressions, and how to write them here.

In a pattern `PATH`, `EXPR`, `DOMAIN`, `NAME`, `INT`, `STRING` stand for such a part, `NAMES` and `TURNS` for several names; `[a|b]` is one or
the other; all else is meant literally. In what stands instead, `{1}` is the first part, `{minus1}` it with the other sign, `{all1}` it in
brackets if need be.
"""

import re
from collections.abc import Iterator, Mapping
from itertools import product

from sjdsl.compiler.diagnostics.frozen import Record


class Phrase(Record):
    """`explanation`: the help line, unless that is "write …"."""

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
        """Returns the help line, with the author's own parts."""
        return self.explanation.format(**{f"_{key}": text for key, text in parts.items()})


def names(text: str) -> list[str]:
    """Returns the names of a list, with what stands in brackets behind them."""
    return [name for name in re.findall(r"\w+(?:\s*\([^)]*\))?", text) if name != "then"]


WRITES = (  # reward and writes
    ("[reward|pay|award] PATH [with|by|] EXPR", "give {2} to {1}"),
    ("[reward|pay|award] EXPR to PATH", "give {1} to {2}"),
    ("[take|deduct] EXPR from NAME . NAME", "add {minus1} to {2}.{3}"),
    ("[take|deduct] EXPR [|reward] from agent", "give {minus1} to agent"),
    ("[fine|punish|penalise|penalize|charge] PATH [|by|with] EXPR", "give {minus2} to {1}"),
    ("give EXPR to [agents|all agents|each agent|every agent]", "give {1} to all"),
    ("give EXPR to [all others|the others|other agents|all other agents]", "give {1} to all but agent"),
    ("give PATH EXPR", "give {2} to {1}"),
    ("give EXPR", "give {1} to agent", "say to whom: `give {1} to agent`"),
    ("NAME . reward [=|+ =] EXPR", "give {2} to {1}"),
    ("NAME . reward - = EXPR", "give {minus2} to {1}"),
    ("PATH + = EXPR", "add {2} to {1}"),
    ("PATH - = EXPR", "add {minus2} to {1}"),
    ("PATH + +", "add 1 to {1}"),
    ("PATH - -", "add -1 to {1}"),
    ("set PATH to EXPR", "set {1} = {2}"),
    ("set PATH + = EXPR", "add {2} to {1}"),
    ("set PATH - = EXPR", "add {minus2} to {1}"),
    (
        "NAME = EXPR",
        "set {1} = {2}",
        "`set {1} = {2}` writes a field of the world, or in a variant a number; `let {1} = {2}` names a value in this block",
    ),
    ("PATH = EXPR", "set {1} = {2}"),
    ("[increment|increase] PATH by EXPR", "add {2} to {1}"),
    ("[increment|increase] PATH", "add 1 to {1}"),
    ("[decrement|decrease] PATH by EXPR", "add {minus2} to {1}"),
    ("[decrement|decrease] PATH", "add -1 to {1}"),
    ("subtract EXPR from PATH", "add {minus1} to {2}"),
)
CERTAIN = "say which cell: `send {1} to KIND where KIND.row == {2} and KIND.col == {3}`, with a kind of cell for KIND"
ALONE = "`otherwise` follows `when`, `chance`, `pick` and `first`; after `each … where c {{ … }}` write `each … where not c {{ … }}`"
PLACES = (  # places, repetition and conditions
    ("[put|place|spawn|teleport|move|respawn] PATH [at|on|in|to|onto] DOMAIN", "send {1} to {2}"),
    ("send PATH [at|on|in|onto] DOMAIN", "send {1} to {2}"),
    ("send PATH to ( EXPR , EXPR )", "send {1} to grass", CERTAIN),
    ("[kill|delete|destroy|eliminate] PATH", "remove {1}"),
    ("[for each|for all|for every|forall] DOMAIN", "each {1}"),
    ("for NAME in agents", "each agent as {1}"),
    ("for NAME in NAME", "each {2} as {1}"),
    ("each DOMAIN , DOMAIN", "each {1}", "write one statement inside the other: `each {1} {{ each {2} {{ … }} }}`"),
    ("[each|every] EXPR steps", "when step % {1} == 0"),
    ("pick DOMAIN", "pick 1 {1}"),
    ("[end episode|end game|end the episode|end the game]", "end"),
    ("tick", "end", "`tick` stands in the schedule, among the phases: `schedule … -> tick`"),
    ("[when chance|if chance|with probability|with chance|with prob|probability|prob] EXPR", "chance {1}"),
    ("[else if|elif|elsif|elseif] EXPR", "otherwise when {1}"),
    ("else", "otherwise"),
    ("[else|otherwise]", "each agent", ALONE),
    ("move [all agents|every agent|agents|all|]", "move each agent"),
    ("agents", "agent"),
)
SOUGHT = "`when` is followed by `choose`; what is sought has its condition behind `where`: "
CHOICE = "a choice has its condition, `when … choose {1}`; one that holds always is `when step >= 0 choose {1}`"
POLICIES = (  # rules of policies, and slots of scenarios
    (
        "[go to|goto|go towards|go toward|walk to|move to|head to|approach|chase|follow|find|seek a] DOMAIN",
        "seek {1}",
    ),
    ("[avoid|but avoid|not|without|except] DOMAIN", "avoiding {1}", "what is avoided stands behind what is sought: `seek … avoiding {1}`"),
    ("when EXPR [do|act|play|take|use] NAME", "when {1} choose {2}"),
    ("aim NAME at DOMAIN [do|act|play|take|use] NAME", "aim {1} at {2} choose {3}"),
    ("[do|act|choose|play|take|use] NAME", "when step >= 0 choose {1}", CHOICE),
    (
        "[do|act|choose|play|take|use] NAME [at|to] DOMAIN",
        "aim line(1) at {2} choose {1}",
        "say in which shape: `aim line(3) at {2} choose {1}`",
    ),
    ("when EXPR seek DOMAIN", "seek {2}", SOUGHT + "`seek {2} where {1}`"),
    ("when EXPR aim NAME at DOMAIN choose NAME", "aim {2} at {3} choose {4}", SOUGHT + "`aim {2} at {3} where {1}`"),
    ("when EXPR { NAME }", "when {1} choose {2}"),
    ("aim NAME at DOMAIN with NAME", "aim {1} at {2} choose {3}"),
    ("aim at DOMAIN [with|choose] NAME", "aim line(3) at {1} choose {2}", "say in which shape: `aim line(3) at {1} choose {2}`"),
    ("otherwise seek DOMAIN", "seek {1}", "rules are tried in their order, and the first that applies acts: leave out `otherwise`"),
    ("otherwise NAME", "when step >= 0 choose {1}", "rules are tried in their order: as the last write `when step >= 0 choose {1}`"),
    ("slots EXPR [|of|with] NAME", "slots {1} policy {2}"),
    ("slots focal EXPR", "slots {1} focal"),
    ("slots NAME EXPR", "slots {2} policy {1}"),
)
EXPRESSIONS = (  # places, comparisons, counting without brackets, and what cannot be had over a domain
    ("PATH [is on|on the] NAME", "{1} on {2}"),
    ("chose NAME", "agent chose {1}"),
    ("[near|around|close to] NAME", "in disc(1) of {1}"),
    ("[next to|adjacent to|beside] NAME", "in diamond(1) of {1}"),
    ("within INT of NAME", "in disc({1}) of {2}"),
    ("in [radius|distance|range] INT of NAME", "in disc({1}) of {2}"),
    *((f"INT {a} PATH {b} INT", f"{{2}} {a.replace('<', '>')} {{1}} and {{2}} {b} {{3}}") for a in ("<", "<=") for b in ("<", "<=")),
    *((f"PATH {a} INT and {b} INT", f"{{1}} {a} {{2}} and {{1}} {b} {{3}}") for b in ("<", "<=") for a in (">", ">=")),
    ("[count|number of] DOMAIN", "count({1})"),
    ("sum [|of] EXPR over DOMAIN", "sum({1} over {2})"),
    ("sum EXPR", "sum({1})"),
    ("max [|of] EXPR over DOMAIN", "max({1} over {2})"),
    ("min [|of] EXPR over DOMAIN", "min({1} over {2})"),
)
WINDOW = "a window is given by its sides, as in `window ahead 9, behind 1, left 5, right 5`"
GLYPH = 'each kind has a glyph, the character that stands for it on the map: `kind {1} "."`'
UNIT = "count, steps, cells, reward, probability or fraction"
TYPED = "a field has a type before its first value: a range `field {1} : 0 .. 9 = 0`, or words `field {1} : {{ red, blue }} = red`"
WHOLE = "a field of whole numbers is written with its range: `field {1} : 0 .. 100 = 0`"


def _windows() -> Iterator[tuple[str, str]]:
    for number in (4, 3, 2, 1):
        sides = [(2 * i + 1, 2 * i + 2) for i in range(number)]
        yield "window " + " , ".join(["INT NAME"] * number), "window " + ", ".join(f"{{{name}}} {{{value}}}" for value, name in sides)
        pattern = " , ".join(["NAME {sign} INT"] * number)
        for sign in ("=", ":"):
            yield "window " + pattern.format(sign=sign), "window " + ", ".join(f"{{{name}}} {{{value}}}" for name, value in sides)


def _lists() -> Iterator[tuple[str, str]]:
    for number in (4, 3, 2):
        events = "  ".join(f"event {{{i + 1}}}" for i in range(number))
        yield "event " + " , ".join(["NAME"] * number), events
        yield "show " + " , ".join(["PATH"] * number), events.replace("event", "show")


DECLARATIONS = (  # signs that declarations do not have, and lists with other signs between
    ("episode [=|:] EXPR", "episode {1}"),
    ("[episodes|horizon|max_steps|episode_length] [=|:|] EXPR", "episode {1}"),
    ("episode EXPR steps", "episode {1}"),
    *_windows(),
    (
        "window [INT x INT|INT , INT|INT by INT|INT|= INT|= INT x INT|= INT , INT]",
        "window ahead {1}, behind {1}, left {1}, right {1}",
        WINDOW,
    ),
    ("schedule TURNS", "schedule {1}"),
    ("schedule [=|:] TURNS", "schedule {1}"),
    ("schedule { TURNS }", "schedule {1}"),
    ("[view|vision|sight] INT", "window ahead {1}", WINDOW),
    ("kind NAME STRING , NAME STRING", "kind {1} {2}  kind {3} {4}"),
    ("kind NAME", 'kind {1} "."', GLYPH),
    ("[blocks|solid|blocking|impassable|blocked]", "blocks agents"),
    ("agents NAME , NAME", "agents 2", "agents have numbers, not names: `agents 2 {{ … }}`; roles are kept in fields"),
    ("agents [=|:] EXPR", "agents {1}"),
    ("moves [=|:] NAME", "moves {1}"),
    ("kind NAME [=|:] STRING", "kind {1} {2}"),
    ("[acts|actions] = NAMES", "acts {1}"),
    ("[acts|actions] : NAMES", "acts {1}"),
    ("[acts|actions] { NAMES }", "acts {1}"),
    ("[acts|actions] NAMES", "acts {1}"),
    *_lists(),
    ("param NAME [=|:|] EXPR", "param {1} : reward = {2}", f"a number has a unit, `param {{1}} : reward = {{2}}`: {UNIT}"),
    ("size NAME [=|:|] EXPR", "size {1} : count = {2}", f"a number has a unit, `size {{1}} : count = {{2}}`: {UNIT}"),
    ("reward NAME [=|:] EXPR", "param {1} : reward = {2}"),
    ("field NAME : INT [to|-] INT", "field {1} : {2} .. {3}"),
    ("field NAME : [ INT , INT ]", "field {1} : {2} .. {3}"),
    ("field NAME = EXPR", "field {1} : 0 .. 9 = {2}", TYPED),
    ("field NAME : count = EXPR", "field {1} : 0 .. 100 = {2}", WHOLE),
    ("field NAME : count", "field {1} : 0 .. 100 = 0", WHOLE),
)
MEASURED = "`mean {1} = {2}` is averaged over an episode, `final {1} = {2}` is its value at the end"
CHECKS = (
    ("always [each|for each|for all|forall] DOMAIN : EXPR", "always count({1}{and1} not {all2}) == 0"),
    ("[NAME|sum NAME|total NAME|metric NAME] [=|:] EXPR", "mean {1} = {2}", MEASURED),
    ("mean NAME : EXPR", "mean {1} = {2}", MEASURED),
    ("total NAME", "event {1}", "`event {1}` counts what `tally {1}` reports; `mean` and `final` measure"),
    ("[never|always never] EXPR", "always not {all1}"),
    ("eventually EXPR", "expect {1} with random over 30 episodes"),
)


def _phrases(pattern: str, instead: str, explanation: str = "") -> Iterator[Phrase]:
    """Yields the phrases of a row. Parts are numbered in the table, and named in templates."""
    instead, explanation = (re.sub(r"\{(\w+)\}", r"{_\1}", template) for template in (instead, explanation))
    literal, *others = re.split(r"\[([^\]]*\|[^\]]*)\]", pattern)
    choices = [[literal], *(part.split("|") if number % 2 == 0 else [part] for number, part in enumerate(others))]
    for parts in product(*choices):
        yield Phrase(tuple("".join(parts).split()), instead, explanation)


PHRASES = tuple(
    phrase for table in (WRITES, PLACES, POLICIES, EXPRESSIONS, DECLARATIONS, CHECKS) for row in table for phrase in _phrases(*row)
)
