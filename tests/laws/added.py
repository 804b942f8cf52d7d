"""A game's text with rules added in every phase and a phase of their own: some that never fire, some that fire and change nothing else.

Each draws for everybody and picks somebody; what it writes is read by nobody.
"""

import re

from sjdsl.compiler.diagnostics.source import Source

PARAM = "param law_never : count = 0 in 0 .. 1"
FIELD = "field law_tally : 0 .. 9 capped = 0"
NEVER = "when law_never > 0 { chance 0.5 { add 1 to law_tally } otherwise chance 0.5 { add 2 to law_tally } }"
DRAWN = "each agent as law_one { chance 0.5 { add 1 to law_tally } }"
PICKED = "pick 1 agent as law_one { draw law_word from 1 .. 3 add law_word to law_tally }"
RULES = f"{NEVER} {DRAWN} {PICKED}"
_PHASE = re.compile(r"^(\s*phase (?!start\b)\w+(?:\([\w, ]*\))? \{)(?=\s*(.*))", re.MULTILINE)
_SCHEDULE = re.compile(r"^(\s*schedule )", re.MULTILINE)


def with_rules(source: Source) -> Source:
    """Returns the text with rules that no other rule reads: at the beginning of every phase but those that move, and first of all."""
    text = _PHASE.sub(_added, source.text)
    text = _SCHEDULE.sub(r"\1law_phase -> ", text)
    own = f"  {PARAM}\n  {FIELD}\n  phase law_phase {{ {RULES} }}\n"
    name = re.search(r"^game .*\{.*$", text, re.MULTILINE)
    assert name is not None
    return Source(
        source.name, f"{text[: name.end()]}\n{own}{text[name.end() + 1 :]}", source.folder
    )


def _added(found: re.Match[str]) -> str:
    return found[1] if "move each" in found[2] else f"{found[1]} {RULES} "
