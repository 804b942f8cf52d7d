"""As many damaged games as one likes: a table of what became of them, and each that is answered far from the edit, or not at all.

`python -m tests.damage.campaign --examples 5000 --seed 0`, or `make damage EXAMPLES=5000 SEED=0`.
"""

import argparse
import time
from collections import Counter, defaultdict
from random import Random

from tests.damage.edits import GAMES, KINDS, Edit, edit, place
from tests.damage.judge import Verdict, judge
from tests.damage.noise import SORTS, fault_of, noise
from tests.damage.nothing import CLASSES, class_of

OUTCOMES = ("refused", "warned", "other", "same", "fault")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--examples", type=int, default=500)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--noise", type=int, default=150, help="files of each sort of noise")
    given = options.parse_args()
    looked = []
    for number in range(given.seed, given.seed + given.examples):
        looked.append(look(number))
        tell(*looked[-1])
    table(looked)
    random = Random(given.seed)
    for sort in SORTS:
        files = [noise(sort, random) for _ in range(given.noise)]
        faults = [fault for data in files if (fault := fault_of(data))]
        print(f"{len(files)} files of {sort}: {len(faults)} faults {faults[:3]}", flush=True)


def look(number: int, lowered: bool = True) -> tuple[Edit, Verdict]:
    """Returns the edit of a number and what becomes of it; numbers in a row go through all games and all kinds."""
    game = GAMES[number % len(GAMES)]
    kind = KINDS[number // len(GAMES) % len(KINDS)]
    made = edit(game, kind, Random(number))
    return made, judge(made, lowered)


def tell(edited: Edit, verdict: Verdict) -> None:
    """Prints an edit that is not answered as it should be."""
    if verdict.outcome in ("refused", "warned") and verdict.near and len(verdict.found) <= 3:
        return
    if verdict.outcome == "other" or (verdict.outcome == "same" and class_of(edited)):
        return
    what = "MANY" if verdict.near else "FAR " if verdict.found else verdict.outcome.upper()
    print(what, place(edited), verdict.fault, flush=True)
    for message in verdict.messages[:6]:
        print("       ", message)


def table(looked: list[tuple[Edit, Verdict]]) -> None:
    """Prints how many of each kind of edit came to what, how near the answers are and how many."""
    rows: dict[str, Counter[str]] = defaultdict(Counter)
    slowest, begun = 0.0, time.process_time()
    for edited, verdict in looked:
        for row in (edited.kind, "all"):
            rows[row]["edits"] += 1
            rows[row][verdict.outcome] += 1
            if verdict.found:
                rows[row]["answered"] += 1
                rows[row]["near"] += verdict.near
                rows[row]["messages"] += len(verdict.found)
                rows[row]["one"] += len(verdict.found) == 1
                rows[row]["most"] = max(rows[row]["most"], len(verdict.found))
        slowest = max(slowest, verdict.seconds)
    for name, reason in CLASSES.items():
        count = sum(
            verdict.outcome == "same" and class_of(edited) == name for edited, verdict in looked
        )
        print(f"same rules, {count} times: {name} ({reason})")
    print(
        "| edit | files | refused | warned | other rules | the same | faults | near | messages | one | most |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for name, row in rows.items():
        answered = max(1, row["answered"])
        counts = " | ".join(str(row[outcome]) for outcome in OUTCOMES)
        near, one = (f"{100 * row[what] / answered:.1f}%" for what in ("near", "one"))
        print(
            f"| {name} | {row['edits']} | {counts} | {near} | {row['messages'] / answered:.2f} | {one} | {row['most']} |"
        )
    print(f"slowest {slowest:.2f} s, {begun:.0f} s in all")


if __name__ == "__main__":
    main()
