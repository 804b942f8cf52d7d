"""The process section of a rule sheet: the order of events in a step, and what each phase can change."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields, body_sort, body_sorts, written_field
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
    found = ["timers fall"] * any(field.timer for field in all_fields(v.game))
    found += [f"agents{' and movers' if v.game.movers else ''} that are away come nearer"] * v.waits
    return f"`tick`: {joined(found or ['nothing'])}"


def _touches(phase: ir.Phase, v: Vocabulary) -> str:
    """Returns what a phase can change, in short."""
    nodes = v.phases[phase.label]
    fields = [_written(n.target, v) for n in nodes if isinstance(n, ir.Set | ir.Add)]
    found = [f"sets {joined(dict.fromkeys(fields))}"] if fields else []
    places = ((ir.Move, "move"), (ir.Send, "are sent elsewhere"), (ir.Shift, "are sent to one cell"), (ir.Remove, "are taken away"))
    sorts = ((ir.Give, "gives rewards"), (ir.Mark, "marks cells"), (ir.End, "can end the episode"))
    for who in body_sorts(v.game):
        many = "agents" if who.what == "agent" else f"{who.name} movers"
        found += [f"{many} {does}" for sort, does in places if any(isinstance(n, sort) and _of(n) == who for n in nodes)]
    found += [text for sort, text in sorts if any(isinstance(n, sort) for n in nodes)]
    events = dict.fromkeys(n.event for n in nodes if isinstance(n, ir.Tally))
    found += [f"counts {codes(events)}"] if events else []
    return f": {'; '.join(found)}" if found else ": nothing"


def _of(s: ir.Node) -> ir.Sort:
    """Returns the sort of those whom a statement moves or sends."""
    if isinstance(s, ir.Move):
        return s.domain.var.sort
    assert isinstance(s, ir.Send | ir.Shift | ir.Remove)
    return body_sort(s.who)


def _written(target: ir.Expr, v: Vocabulary) -> str:
    read = written_field(target)
    owners = {"agent": "agents", "world": "the world", "mover": f"{read.held_by.name} movers"}
    owner = owners.get(read.held_by.what) or f"{v.kinds(read.held_by.names)} cells"
    return f"{code(read.name)} of {owner}"
