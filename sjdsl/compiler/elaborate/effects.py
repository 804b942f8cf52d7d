"""Elaborates the effects `give`, `tally` and `send`, and whom they reach."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.domains import domain, only_one_who, without
from sjdsl.compiler.elaborate.keys import key_of
from sjdsl.compiler.elaborate.lookup import as_agent, check_somebody
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.runtime.actions import HEADINGS

FACINGS = (*HEADINGS, "same")
LATER = "who is sent `after` some ticks finds its cell when it comes back: keep what it needs in a field of its own, set before it is sent"


def agent(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent."""
    built = scope.expression(e)
    if not as_agent(built):
        raise wrong_type(scope, e, "an agent", built.type)
    check_somebody(built, e.span, scope)
    return built


def receiver(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent or a set of agents."""
    built = scope.expression(e)
    if built.type.kind == "agents" and not built.type.by:
        return built
    if not as_agent(built):
        raise wrong_type(scope, e, "an agent or a set of agents", built.type)
    check_somebody(built, e.span, scope)
    return built


def give(s: ast.Give, scope: Scope) -> ir.Stmt:
    value = scope.number(s.value, ("reward",), "a reward")
    if isinstance(s.receiver, ast.All):
        but = None
        if s.receiver.but is not None:
            member = scope.expression(ast.Path(s.receiver.but.span, s.receiver.but, ()))
            if not (isinstance(member, ir.Member) and member.who == "agent"):
                raise wrong_type(scope, ast.Path(s.receiver.but.span, s.receiver.but, ()), "an agent", member.type)
            but = member
        return ir.Give(value=value, receiver=None, but=but, origin=s.span)
    return ir.Give(value=value, receiver=receiver(s.receiver, scope), origin=s.span)


def tally(s: ast.Tally, scope: Scope) -> ir.Stmt:
    static = scope.static
    name = s.event.name
    event = static.events.get(name.text)
    if event is None:
        raise scope.problems.fail(errors.NoEvent(name.span, name=name.text, near=near(name.text, static.events)))
    word = None
    if event.by is not None:
        if len(s.event.steps) != 1 or not isinstance(s.event.steps[0], ast.Index):
            raise scope.problems.fail(errors.WrongType(s.event.span, wanted=f"`{name.text}[word]`", given="the whole row"))
        if name.text not in static.event_levels:
            raise Poisoned
        word = key_of(s.event.steps[0].key, name.text, static.event_levels[name.text], scope)
    elif s.event.steps:
        raise scope.problems.fail(errors.WrongType(s.event.span, wanted="the event alone", given="an entry of it"))
    amount = None if s.by is None else scope.number(s.by, ("count",), "a count")
    if s.by is not None and amount is not None and amount.type.low < 0:
        raise scope.problems.fail(errors.Negative(s.by.span, name="what is counted"))
    for_ = None if s.receiver is None else receiver(s.receiver, scope)
    return ir.Tally(event=name.text, word=word, amount=amount, receiver=for_, origin=s.span)


def facing(name: ast.Name | None, scope: Scope) -> str | None:
    """Returns which way an agent looks that is sent; None if that is not said."""
    if name is not None and name.text not in FACINGS:
        raise scope.problems.unknown(name, FACINGS, "what an agent can be made to face")
    return None if name is None else name.text


def send(s: ast.Send, scope: Scope, use: PhaseUse) -> ir.Stmt:
    who = agent(s.who, scope)
    around = scope if s.after is None else only_one_who(scope, who, LATER)
    destination, _ = domain(s.domain, without(around, (s.domain.bind or s.domain.kind).text))
    if destination.var.who != "cell" or destination.on is not None or destination.restriction is not None:
        raise scope.problems.fail(errors.WrongType(s.domain.span, wanted="a kind of cell, perhaps with `where`", given="another domain"))
    after = None if s.after is None else scope.number(s.after, ("steps",), "a number of steps")
    if s.after is not None and after is not None and after.type.low < 0:
        raise scope.problems.fail(errors.Negative(s.after.span, name="the delay"))
    if isinstance(after, ir.Number) and after.value == 0:
        after = None
    look = facing(s.facing, scope)
    if s.stay is not None and s.stay.text != "stay":
        raise scope.problems.fail(errors.UnknownName(s.stay.span, name=s.stay.text, help="write `otherwise stay`: who finds no cell stays"))
    place = use.streams.header(s.domain.span, s.domain.span.end)
    pool = use.pools.setdefault(place, len(use.pools))
    return ir.Send(
        who=who,
        domain=destination,
        after=after,
        facing=look,  # type: ignore[arg-type]
        stay=s.stay is not None,
        pool=pool,
        order_stream=use.streams.shared("send to", place),
        heading_stream=use.streams.shared("heading of those sent to", place),
        origin=s.span,
    )
