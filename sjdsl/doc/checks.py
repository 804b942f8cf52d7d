"""The sections of a rule sheet on episodes, metrics and checks."""

from sjdsl.compiler import ir
from sjdsl.doc.phrases import value
from sjdsl.doc.quoted import laid_out, written_text
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, codes, counted, entries_text, fenced
from sjdsl.doc.written import Written

SORTS = {
    "require": "holds of the numbers",
    "always": "holds after every step",
    "once": "from the first step on after which the first condition holds, the second holds",
    "conserved": "never changes",
    "monotone": "where the argument is larger, the value is never larger (`falling`), or never smaller (`rising`)",
    "symmetric": "numbering the agents, or the movers of that name, in another order changes nothing but their numbers",
    "expect": "holds at the end of so many episodes in which the agents play these policies, in turn; `random` chooses all actions equally "
    "likely, `never` all but the ones it names, and `seek` walks to the nearest of what it names",
}
PAYOFFS = (
    "R is what each earns if both cooperate, P if both do not; T and S are what one earns who does not cooperate with one who does, "
    "and the other way round."
)


def episode(v: Vocabulary) -> list[str]:
    """Returns when an episode is over."""
    length = v.game.episode
    steps = counted(length.value, "step") if isinstance(length, ir.Number) else f"{value(length, v)} steps"
    found = [f"An episode is cut off (truncated) after {steps}; the reward of the last step counts."]
    ending = [label for label, nodes in v.phases.items() if any(isinstance(node, ir.End) for node in nodes)]
    if ending:
        found.append(f"It can end before (terminated) in phase {codes(ending, 'or')}; if both happen at once it is terminated.")
    return [" ".join(found), ""]


def metrics(v: Vocabulary) -> list[str]:
    """Returns what is counted and measured."""
    lines = metric_lines(v)
    return [*bullets(lines), ""] if lines else ["None but the rewards.", ""]


def metric_lines(v: Vocabulary) -> list[Line]:
    """Returns a sentence for each event and each measure, which begins with its name."""
    found = []
    for event in v.game.events:
        whom = "for each agent" if event.per_agent else "for the whole game"
        if event.by is not None:
            whom += f", separately {f'for {codes(event.by.names)}' if event.by.sort == 'word' else entries_text(event.by)}"
        found.append(Line(f"{code(event.name)}: an event counted {whom}"))
    for measure in v.game.measures:
        when = "the mean over the steps of an episode of" if measure.mean else "at the last step of an episode"
        found.append(Line(f"{code(measure.name)}: {when} {value(measure.value, v)}, read at the end of each step"))
    return found


def checks(w: Written) -> list[str]:
    """Returns the checks as they are written, after what each sort of check says."""
    found = [check for block in w.composition.checks.values() for check in block]
    if not found:
        return ["None.", ""]
    sorts = {check.sort for check in w.game.checks}
    said = [*bullets(Line(f"{code(sort)}: {meaning}") for sort, meaning in SORTS.items() if sort in sorts), ""]
    said += [PAYOFFS, ""] if any(isinstance(node, ir.MatrixClass) for node in ir.walk(w.game)) else []
    return [*said, *fenced(laid_out(written_text(w.composition, found), "checks")), ""]
