"""The process section of a rule sheet: the order of events in a step, and what each phase can change."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields, mover_sort, written_field
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import capital, code, codes, joined


def overview(v: Vocabulary) -> list[str]:
    """Returns the schedule as a numbered list, with what the environment does before and after the phases."""
    game = v.game
    steps = ["every agent has chosen an action" + (", and forbidden ones become `stay`" if game.agents.forbids else "")]
    steps += [_tick(v) if isinstance(t, ir.Tick) else f"{code(t.label)}{_touches(t, v)}" for t in game.schedule]
    steps += ["rewards, counts and metrics of the step are read", "the number of finished steps grows by 1", "the agents observe"]
    return [*(f"{i}. {capital(text)}." for i, text in enumerate(steps, 1)), ""]


def _tick(v: Vocabulary) -> str:
    found = ["timers fall"] if any(field.timer for field in all_fields(v.game)) else []
    found += [f"{v.bodies} that are away come nearer"] if v.waits else []
    return f"`tick`: {joined(found) if found else 'nothing'}"


def _touches(phase: ir.Phase, v: Vocabulary) -> str:
    """Returns what a phase can change, in short."""
    nodes = v.phases[phase.label]
    fields = [_written(n.target, v) for n in nodes if isinstance(n, ir.Set | ir.Add)]
    found = [f"sets {joined(dict.fromkeys(fields))}"] if fields else []
    places = ((ir.Move, "move"), (ir.Send, "are sent elsewhere"), (ir.Shift, "are sent to one cell"), (ir.Remove, "are taken away"))
    sorts = (
        (ir.Give, "gives rewards"),
        (ir.Mark, "marks cells"),
        (ir.End, "can end the episode"),
    )
    for who, many in (("", "agents"), *((sort.name, f"{sort.name} movers") for sort in v.game.movers)):
        found += [f"{many} {does}" for sort, does in places if any(isinstance(n, sort) and _of(n) == who for n in nodes)]
    found += [text for sort, text in sorts if any(isinstance(n, sort) for n in nodes)]
    events = dict.fromkeys(n.event for n in nodes if isinstance(n, ir.Tally))
    found += [f"counts {codes(events)}"] if events else []
    return f": {'; '.join(found)}" if found else ": nothing"


def _of(s: ir.Node) -> str:
    """Returns the sort of the movers that a statement moves or sends; nothing for agents."""
    match s:
        case ir.Move():
            return mover_sort(s.domain.var)
        case ir.Send() | ir.Shift() | ir.Remove():
            return mover_sort(s.who)
        case _:
            raise AssertionError(s)


def _written(target: ir.Expr, v: Vocabulary) -> str:
    read = written_field(target)
    owners = {"agent": "agents", "world": "the world", "mover": f"{' '.join(read.kinds)} movers"}
    owner = f"{v.kinds(read.kinds)} cells" if read.held_by == "cell" else owners[read.held_by]
    return f"{code(read.name)} of {owner}"
