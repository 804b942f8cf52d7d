"""Coverage of a step as a set of features: statements that ran, how often, in which pairs, and branches of chances taken."""

from collections import Counter
from collections.abc import Iterable
from itertools import combinations

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.properties.statements import STARTING, StatementId, statement_id

Feature = tuple[object, ...]
MANY = 3  # more instances of a statement in one step than this are not told apart


def features_of(accounts: Iterable[Account]) -> frozenset[Feature]:
    """Returns the features of a step: (ran, id), (times, id, n), (branch, id, which), (added, label, field, n), (both, id, id)."""
    ran: Counter[StatementId] = Counter()
    found: set[Feature] = set()
    for account in accounts:
        if not isinstance(account.turn, ir.Phase):
            continue
        label = STARTING if account.turn.name == STARTING else account.turn.label
        ran.update(statement_id(label, done.statement) for done in account.done)
        added = Counter(slot for done in account.done for slot, _ in done.written.get("adds", ()))
        found |= {("added", label, slot.name, min(n, MANY)) for slot, n in added.items() if n > 1}
        found |= {("branch", statement_id(label, d.statement), d.result) for d in account.drawn if isinstance(d.statement, ir.Chance)}
    found |= {("ran", statement) for statement in ran}
    found |= {("times", statement, min(n, MANY)) for statement, n in ran.items() if n > 1}
    found |= {("both", *pair) for pair in combinations(sorted(ran), 2)}
    return frozenset(found)


def statements_run(features: Iterable[Feature]) -> set[StatementId]:
    """Returns the statements that ran."""
    return {feature[1] for feature in features if feature[0] == "ran"}  # type: ignore[misc]
