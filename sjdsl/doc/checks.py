"""The English of episodes, metrics and checks in a rule sheet."""

from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.doc.actions import chosen_names
from sjdsl.doc.phrases import condition, members, value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, codes, counted, entries_text, joined

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


def checks(v: Vocabulary) -> list[str]:
    """Returns the lines of the checks."""
    lines = [check_line(check, v) for check in v.game.checks]
    if not lines:
        return ["None.", ""]
    return [*bullets(lines), "", *([PAYOFFS, ""] if v.has(ir.MatrixClass) else [])]


def check_line(check: ir.Check, v: Vocabulary) -> Line:
    """Returns one check."""
    match check.sort:
        case "require":
            return Line(f"of the numbers: {condition(check.values[0], v)}")
        case "always":
            return Line(f"after every step: {condition(check.values[0], v)}")
        case "once":
            first, then = (condition(c, v) for c in check.values)
            return Line(f"from the first step on after which {first}: {then}")
        case "conserved":
            return Line(f"never changes: {value(check.values[0], v)}")
        case "monotone":
            direction, name, argument = check.words
            grows = "never larger" if direction == "falling" else "never smaller"
            meanings = [(value(e, v), n) for e, n in zip(check.values, (name, argument), strict=True)]  # said where they stand nowhere else
            of, what = (said if n in v.defined else f"{code(n)} ({said})" for said, n in meanings)
            return Line(f"where {what} is larger, {of} is {grows}")
        case "symmetric":
            (what,) = check.words
            whom = "the agents" if what == "agents" else f"the movers {code(what)}"
            return Line(f"numbering {whom} in another order changes nothing but their numbers")
        case "expect":
            who = joined(policy(p, v) for p in check.policies)
            turn = ", in turn" if len(check.policies) > 1 else ""
            return Line(
                f"at the end of {counted(check.episodes, 'episode')} in which the agents {who}{turn}: {condition(check.values[0], v)}"
            )
        case _:
            assert_never(check.sort)


def policy(p: ir.Policy, v: Vocabulary) -> str:
    """Returns how agents of a policy play."""
    match p.name:
        case "random":
            return "choose all actions equally likely"
        case "never":
            return f"choose all actions but {joined(chosen_names(p.actions, v))} equally likely"
        case "seek":
            assert p.domain is not None
            return f"walk to the nearest {members(p.domain, v)} (the agent: the one who walks)"
        case "scripted":
            return f"follow the policy {code(p.scripted)}"
        case _:
            assert_never(p.name)
