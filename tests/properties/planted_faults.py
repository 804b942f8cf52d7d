"""Forty-two planted faults: a variant of each game in `planted/`, and thirty rules for one small game, each with a check that it breaks.

Those of the games need several agents or movers together; those of the rules a rare chance, three agents, six steps, the last step of an
episode, or a bound of a parameter. `python -m tests.properties.planted_faults 0 1` looks for all with these seeds.
"""

import sys
import time
from pathlib import Path

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.properties import Effort, GameFamily, Report, verify_properties

ABOUT_STATES = ("always", "once", "conserved", "monotone")  # checks of the states of a trajectory

FOLDER = Path(__file__).parent / "planted"
GAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.sj")))
WORKS = """sj 1
game works "Plates, numbered tiles and a pillar" {{
  size  crowd : count = 3 in 1 .. 4
  param low   : steps = 2 in 0 .. 9
  param high  : steps = 5 in 0 .. 9
  param rate  : probability = 0.1
  param bonus : reward = 1 in 0 .. 5
  episode 60
  kind floor  "."
  kind plate  "o"
  kind pillar "P" {{ field hands : set of agent  blocks agents }}
  kind tile   "1" {{
    field number : 1 .. 6 = 1  field lit : {{ no, yes }} = no
    glyph "2" with number = 2  glyph "3" with number = 3  glyph "4" with number = 4  glyph "5" with number = 5  glyph "6" with number = 6
  }}
  map {{ "o.1.2."
         "..P..o"
         "3.4.5."
         ".o..6." }}
  agents crowd {{ acts turn_left, turn_right, step_left, step_right, forward, backward, stay, red, green, blue  moves relative }}
  shape touch = line(1)
  field stage : 0 .. 6 = 0
  field paid  : 0 .. 99 capped = 0
  phase start {{ each agent {{ send agent to floor }} }}
  schedule walk -> rest -> hands -> rule
  phase walk {{ move each agent }}
  phase rest {{ each pillar {{ set pillar.hands = nobody }} }}
  phase hands {{ each agent where agent chose red {{ first pillar in touch of agent {{ add agent to pillar.hands }} }} }}
  phase rule {{ {rule} }}
  checks {{ {check} }}
}}
"""
PAY = "{ add 1 to paid }"
ONWARDS = "{ set stage = min(stage + 1, 6) } otherwise { set stage = 0 }"
NEVER_PAID, NEVER_SIX = "always paid == 0", "always stage < 6"


def _count(which: str) -> str:
    return f"count(agent {which})"


def _password(*keys: str) -> str:
    """Returns a condition that holds if agent 0 chooses the key that is next."""
    return " or ".join(
        f"(stage == {i} and {_count(f'where agent.index == 0 and agent chose {key}')} == 1)"
        for i, key in enumerate(keys)
    )


RULES = {  # name: rule, check
    "one chance in 2,000": (f"chance 0.0005 {PAY}", NEVER_PAID),
    "two rare chances, one after the other": (
        f"when stage == 0 {{ chance 0.001 {{ set stage = 1 }} }} otherwise {{ chance 0.001 {PAY} }}",
        NEVER_PAID,
    ),
    "one number in 2,000": (f"draw x from 1 .. 2000  when x == 777 {PAY}", NEVER_PAID),
    "a rare chance for agents that act on a plate": (
        f"each agent on plate where agent chose red {{ chance 0.001 {PAY} }}",
        NEVER_PAID,
    ),
    "all six chances at once": (
        "each tile { chance 0.1 { set tile.lit = yes } otherwise { set tile.lit = no } }",
        "always count(tile where tile.lit is yes) < 6",
    ),
    "four chances in a row": (f"chance 0.02 {ONWARDS}", "always stage < 4"),
    "three on plates": ("set paid = 0", "always count(agent on plate) < 3"),
    "three press red": (f"when {_count('where agent chose red')} == 3 {PAY}", NEVER_PAID),
    "red, green and blue in one step": (
        f"when {' and '.join(_count(f'where agent chose {key}') + ' == 1' for key in ('red', 'green', 'blue'))} {PAY}",
        NEVER_PAID,
    ),
    "three press red on plates": (
        f"when {_count('on plate where agent chose red')} == 3 {PAY}",
        NEVER_PAID,
    ),
    "three lift one pillar": (
        "set paid = 0",
        "always count(pillar where count(agent in pillar.hands) >= 3) == 0",
    ),
    "a plate, a tile and a pillar in one step": (
        f"""when {_count("on plate where agent chose green")} == 1 and {_count("on tile where agent chose blue")} == 1
          and count(pillar where pillar.hands is not nobody) == 1 {PAY}""",
        NEVER_PAID,
    ),
    "six keys of one agent": (
        f"when {_password('red', 'green', 'blue', 'blue', 'red', 'green')} {ONWARDS}",
        NEVER_SIX,
    ),
    "six tiles in order": (
        "when count(tile where tile.number == stage + 1 and not nobody on tile) > 0 { set stage = min(stage + 1, 6) }",
        NEVER_SIX,
    ),
    "six tiles in order, else from the first": (
        """when count(tile where tile.number == stage + 1 and not nobody on tile) > 0 { set stage = min(stage + 1, 6) }
           otherwise when count(tile where tile.number > stage + 1 and not nobody on tile) > 0 { set stage = 0 }""",
        NEVER_SIX,
    ),
    "six keys of two agents in turn": (
        "when "
        + " or ".join(
            f"(stage == {i} and {_count(f'where agent.index == {i % 2} and agent chose {key}')} == 1)"
            for i, key in enumerate(("red", "blue", "green", "red", "blue", "green"))
        )
        + f" {ONWARDS}",
        NEVER_SIX,
    ),
    "six steps in which all three do the same": (
        f"when {' or '.join(_count(f'where agent chose {key}') + ' == 3' for key in ('red', 'green', 'blue'))} {ONWARDS}",
        NEVER_SIX,
    ),
    "five reds, then three greens": (
        f"""when {_count("where agent chose green")} == 3 {{ when stage == 5 {PAY} otherwise {{ set stage = 0 }} }}
           otherwise when {_count("where agent chose red")} == 1 {{ set stage = min(stage + 1, 6) }}""",
        NEVER_PAID,
    ),
    "red in the last step": (
        f"when step == 59 {{ each agent where agent chose red {PAY} }}",
        NEVER_PAID,
    ),
    "two on plates in the last step": (
        f"when step == 59 and {_count('on plate')} == 2 {PAY}",
        NEVER_PAID,
    ),
    "no tile visited until the last step": (
        "each tile where not nobody on tile { set tile.lit = yes }  when step == 59 and stage == 0 { set stage = 1 }",
        "always stage == 0 or count(tile where tile.lit is yes) > 0",
    ),
    "four tiles visited in the last step": (
        "each tile where not nobody on tile { set tile.lit = yes }  when step == 59 { set stage = 1 }",
        "always stage == 0 or count(tile where tile.lit is yes) != 4",
    ),
    "red in each of the last four steps": (
        f"when step >= 56 and {_count('where agent chose red')} > 0 {ONWARDS}",
        "always stage < 4",
    ),
    "a rare chance in the last step": (f"when step == 59 {{ chance 0.01 {PAY} }}", NEVER_PAID),
    "a number at its maximum": (f"when high == 9 {PAY}", NEVER_PAID),
    "two numbers at opposite ends": (f"when low == 9 and high == 0 {PAY}", NEVER_PAID),
    "a chance that is certain": (f"when rate >= 1 and {_count('on plate')} > 0 {PAY}", NEVER_PAID),
    "a reward at its maximum for agents that act on a plate": (
        f"when bonus >= 5 {{ each agent on plate where agent chose red {PAY} }}",
        NEVER_PAID,
    ),
    "as many agents as allowed press red": (
        f"when {_count('where agent chose red')} == 4 {PAY}",
        NEVER_PAID,
    ),
    "low above high when two press blue": (
        f"when low > high and {_count('where agent chose blue')} == 2 {PAY}",
        NEVER_PAID,
    ),
}


FAULTS = (*GAMES, *RULES)


def planted(game: str, variant: str | None = "fault") -> GameFamily:
    """Returns a game with its fault; without, for None."""
    return GameFamily(read_source(FOLDER / f"{game}.sj"), (variant,) if variant else ())


def faulty(name: str) -> GameFamily:
    """Returns a game with one of the faults."""
    if name in GAMES:
        return planted(name)
    rule, check = RULES[name]
    return GameFamily(Source("works.sj", WORKS.format(rule=rule, check=check), None))


def look_for(name: str, effort: Effort) -> Report:
    """Returns what is found of a fault: the verdict on the check that it breaks."""
    family = faulty(name)
    states = [
        number for number, check in enumerate(family.own.checks) if check.kind in ABOUT_STATES
    ]
    return verify_properties(family, effort, [states[1 if name == "crates" else 0]])


if __name__ == "__main__":
    for name in FAULTS:
        for seed in map(int, sys.argv[1:] or ["0"]):
            start = time.process_time()
            report = look_for(name, Effort(seed=seed))
            (verdict,) = report.verdicts
            found = "found" if verdict.passed is False else "not found"
            print(
                f"{name}, seed {seed}: {found}, {report.steps:,} steps, {time.process_time() - start:.1f} s",
                flush=True,
            )
