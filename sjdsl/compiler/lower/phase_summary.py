"""What a phase does, in one statement for the docstring of its function: who, what is chosen, what changes; conditions are left out."""

from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.printer import expression


def summary(phase: ir.Phase, game: ir.Game) -> str:
    """Returns the statement, such as ``Phase `eat`: for each agent on orchard, sets orchard.fruit to none, gives a reward.``"""
    label = "`start`, before the first step" if phase is game.start else f"`{phase.label}`"
    return f"Phase {label}: {'; '.join(text for text in map(_statement, phase.body) if text) or 'nothing'}."


def _block(body: tuple[ir.Stmt, ...]) -> str:
    return ", ".join(dict.fromkeys(text for text in map(_statement, body) if text))


def _statement(s: ir.Stmt) -> str:
    match s:
        case ir.Let() | ir.Draw():
            return ""
        case ir.Each():
            return _inside(f"for each {_domain(s.domain)}", s.body)
        case ir.Pick():
            number = str(s.number.value) if isinstance(s.number, ir.Number) else "some"
            return _inside(f"picks {number} {_domain(s.domain)}", s.body, s.otherwise)
        case ir.First():
            return _inside(f"for the first {_domain(s.domain)}", s.body, s.otherwise)
        case ir.Match():
            return _inside(f"matches each {_domain(s.left)} with {_domain(s.right)}", s.body)
        case ir.When():
            return _block(tuple(inner for branch in s.branches for inner in branch.body) + s.otherwise)
        case ir.Chance():
            outcomes = [text for text in map(_block, (*(branch.body for branch in s.branches), s.otherwise)) if text]
            return f"by chance {' or else '.join(outcomes)}" if outcomes else ""
        case ir.Set():
            return f"sets {_value(s.target)}" + (f" to {_value(s.value)}" if _value(s.value) else "")
        case ir.Add():
            return f"adds {_value(s.value) or 'to'}{' to' if _value(s.value) else ''} {_value(s.target)}"
        case ir.Give():
            return f"gives a reward to {'all' if s.receiver is None else _value(s.receiver)}"
        case ir.Tally():
            return f"counts {s.event}"
        case ir.Send():
            return f"sends {_value(s.who)} to {' or '.join(s.domain.var.kinds)}" + (" after a delay" if s.after is not None else "")
        case ir.Shift():
            return f"sends {_value(s.who)} {'by some cells' if s.to is None else f'to {_value(s.to)}'}"
        case ir.Remove():
            return f"removes {_value(s.who)}"
        case ir.Move():
            return f"moves each {_domain(s.domain)}{_course(s.course)}"
        case ir.Mark():
            return f"marks {s.shape}"
        case ir.End():
            return "ends the episode"
        case _:
            assert_never(s)


def _course(course: ir.Course | None) -> str:
    match course:
        case None:
            return ""
        case ir.Along():
            return f" along {_value(course.heading) or 'a heading'}"
        case ir.Wander():
            return " at random" if course.goal is None else f" {'away from' if course.away else 'toward'} {_domain(course.goal)}"
        case _:
            assert_never(course)


def _inside(what: str, *bodies: tuple[ir.Stmt, ...]) -> str:
    done = ", ".join(text for text in map(_block, bodies) if text)
    return f"{what}, {done}" if done else ""


def _domain(d: ir.Domain) -> str:
    name = d.var.name if d.var.who == "agent" or d.var.name in d.var.kinds else f"{' or '.join(d.var.kinds)} ({d.var.name})"
    on = "" if d.on is None else f" on {' or '.join(d.on.kinds)}"
    match d.restriction:
        case ir.Near():
            return f"{name}{on} in {d.restriction.shape} of {d.restriction.anchor.name}"
        case ir.InAgents() | ir.InCell():
            return f"{name}{on} in {_value(d.restriction.value) or 'a set'}"
        case ir.Among():
            return f"{name}{on} of {' and '.join(m.name for m in d.restriction.members)}"
        case None:
            return f"{name}{on}"


def _value(e: ir.Expr) -> str:
    """Returns a short expression as text; nothing for a long one."""
    match e:
        case ir.Member() | ir.Local() | ir.ParamRef() | ir.Named():
            return e.name
        case ir.Word() | ir.Truth():
            return str(e.value)
        case ir.Number():
            return f"{e.value:g}"
        case ir.Nobody():
            return "nobody"
        case ir.Nowhere():
            return "nowhere"
        case ir.ArgumentOf():
            return expression(e)
        case ir.FieldRead():
            return f"{_value(e.owner)}.{e.name}" if e.owner is not None else e.name
        case ir.At():
            return f"{_value(e.row)}[{_value(e.key) or '...'}]"
        case ir.Narrowed():
            return _value(e.value)
        case _:
            return ""
