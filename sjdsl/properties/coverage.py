"""What happened in a step, as things that can be counted: sentences that ran, how often, together with which, and branches of chances."""

from collections import Counter
from collections.abc import Iterable
from itertools import combinations

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.properties.statements import STARTING, Place, place_of

Feature = tuple[object, ...]
MANY = 3  # of more instances of a sentence in one step nothing more is noted


def happened_in(told: Iterable[Account]) -> frozenset[Feature]:
    """Returns what happened in a step: ("ran", place), ("times", place, n), ("branch", place, which), ("added", field, n), ("both", place, place)."""
    ran: Counter[Place] = Counter()
    found: set[Feature] = set()
    for account in told:
        if not isinstance(account.turn, ir.Phase):
            continue
        label = STARTING if account.turn.name == STARTING else account.turn.label
        ran.update(place_of(label, done.sentence) for done in account.done)
        added = Counter(slot for done in account.done for slot, _ in done.written.get("adds", ()))
        found |= {("added", label, slot.name, min(n, MANY)) for slot, n in added.items() if n > 1}
        found |= {("branch", place_of(label, d.sentence), d.result) for d in account.drawn if isinstance(d.sentence, ir.Chance)}
    found |= {("ran", place) for place in ran}
    found |= {("times", place, min(n, MANY)) for place, n in ran.items() if n > 1}
    found |= {("both", *pair) for pair in combinations(sorted(ran), 2)}
    return frozenset(found)


def places_run(features: Iterable[Feature]) -> set[Place]:
    """Returns the sentences that ran."""
    return {feature[1] for feature in features if feature[0] == "ran"}  # type: ignore[misc]
