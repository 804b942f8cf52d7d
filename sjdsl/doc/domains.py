"""The English of domains: the agents or cells that a quantifier ranges over."""

from sjdsl.compiler import ir
from sjdsl.doc.conditions import condition, is_compound, say
from sjdsl.doc.expressions import value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import article, code, joined, variable


def members(d: ir.Domain, v: Vocabulary, plural: bool = False, restriction: bool = True) -> str:
    """Returns the members of a domain: `soil cell whose fruit is none and that lies in the disc(1) around the soil cell`.

    Args:
      plural: `soil cells that lie ...`.
      restriction: whether to say where they are looked for; `nearest` says it elsewhere.
    """
    where = d.restriction if restriction else None
    if isinstance(where, ir.Among):
        return _among(d, where, v, plural)
    own, under, rest = _clauses(d, v)
    match where:
        case ir.Near():
            verb = "lie" if d.var.sort.what == "cell" else "stand"
            own.append(f"that {verb}{'' if plural else 's'} in {shape_of(where.shape, where.anchor, v)}")
        case ir.InAgents() | ir.InCell():
            among = "among " if where.value.type.kind == "agents" else ""
            own.append(f"that {'are' if plural else 'is'} {among}{value(where.value, v)}")
    if d.on is not None:
        cell = v.named(d.on)
        own.append(" ".join([f"that {'each stand' if plural else 'stands'} on {article(cell)}", *under]))
    if rest:
        own.append(f"for which {joined(rest)}")
    return " ".join([v.named(d.var, plural), joined(own)] if own else [v.named(d.var, plural)])


def _among(d: ir.Domain, restriction: ir.Among, v: Vocabulary, plural: bool) -> str:
    """Returns a choice among named variables; they are listed at once."""
    own, under, rest = _clauses(d, v)
    listed = joined(v.refer(m) for m in restriction.members)
    noun = v.noun(d.var) + ("s" if plural else "")
    called = f"{noun} {variable(d.var.name)}, standing for {listed} in turn"
    on = [] if d.on is None else [" ".join([f"that stands on {v.a_cell(d.on.kinds)} called {variable(d.on.name)}", *under])]
    said = [*own, *on, *([f"for which {joined(rest)}"] if rest else [])]
    return f"{called}, {joined(said)}" if said else called


def _clauses(d: ir.Domain, v: Vocabulary) -> tuple[list[str], list[str], list[str]]:
    """Returns what is said of the member itself, of the cell under it, and everything else, in this order."""
    own, under, rest = [], [], []
    tests = conjuncts(d.where)
    about_cell = [t for t in tests if d.on is not None and relative(t, d.on, v)]
    for test in tests:
        clause = relative(test, d.var, v)
        if clause:
            own.append(clause)
        elif d.on is not None and about_cell == [test]:
            under.append(relative(test, d.on, v))
        else:
            text = condition(test, v)
            rest.append(f"({text})" if is_compound(test, v) else text)
    return own, under, rest


def conjuncts(test: ir.Expr | None) -> list[ir.Expr]:
    """Returns the parts of `a and b and c`."""
    match test:
        case None:
            return []
        case ir.Logic(fn="and"):
            return [part for arg in test.args for part in conjuncts(arg)]
        case _:
            return [test]


def relative(test: ir.Expr, member: ir.Member, v: Vocabulary) -> str:
    """Returns a condition as a clause behind its noun, `whose fruit is ripe`; empty if it is not about this member."""
    match test:
        case ir.Unoccupied(cell=cell) if _is(cell, member):
            return f"on which no {v.somebody} stands"
        case ir.Not(value=ir.Unoccupied(cell=cell)) if _is(cell, member):
            return f"on which some {v.somebody} stands"
    saying = say(test, v)
    if saying is None:
        return ""
    match saying.subject:
        case ir.FieldRead(owner=owner, name=name) | ir.Attribute(owner=owner, name=name) if _is(owner, member):
            shown = code(name) if isinstance(saying.subject, ir.FieldRead) else name
            return f"whose {shown} {saying.says}"
        case ir.Member() if _is(saying.subject, member) and isinstance(_bare(test), ir.Chose | ir.ChoseWith):
            return f"that {saying.says}"
    return ""


def _bare(test: ir.Expr) -> ir.Expr:
    return _bare(test.value) if isinstance(test, ir.Not) else test


def _is(e: ir.Expr | None, member: ir.Member) -> bool:
    return isinstance(e, ir.Member) and e.name == member.name


def shape_of(shape: str, anchor: ir.Member, v: Vocabulary) -> str:
    """Returns `the beam of agent *zapper*`, `the disc(2) around the soil cell`."""
    directed = v.shapes[shape].directed
    return f"the {code(shape)} {'of' if directed else 'around'} {v.refer(anchor)}"


def nearest(d: ir.Domain, v: Vocabulary) -> tuple[str, str]:
    """Returns the members of a `first`, without the restriction, and the restriction alone."""
    assert isinstance(d.restriction, ir.Near)
    return members(d, v, restriction=False), shape_of(d.restriction.shape, d.restriction.anchor, v)
