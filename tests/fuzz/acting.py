"""Random actions with arguments: declared, asked about, read where they surely were chosen, forbidden, taken by policies."""

from dataclasses import dataclass, replace

from sjdsl.compiler import ir
from tests.fuzz.conditions import condition, somebody, word
from tests.fuzz.declared import Lines, World
from tests.fuzz.quantities import integer
from tests.fuzz.reading import Scope, Typed, Variable
from tests.fuzz.typed_numbers import fitted

NAMES = ("vote", "offer", "say")
ARGUMENTS = ("apples", "whom", "what")


@dataclass(frozen=True)
class Argument:
    """`name` may be empty."""

    name: str
    type: ir.Type


@dataclass(frozen=True)
class Action:
    """An action with arguments."""

    name: str
    arguments: tuple[Argument, ...]

    @property
    def text(self) -> str:
        """Its declaration."""
        return f"{self.name}({', '.join(f'{a.name} : {_sort(a.type)}' if a.name else _sort(a.type) for a in self.arguments)})"

    def read(self, who: str, argument: Argument) -> str:
        return f"{who}.{self.name}" + (f".{argument.name}" if argument.name else "")

    @property
    def readable(self) -> list[Argument]:
        return [a for a in self.arguments if a.name or len(self.arguments) == 1]


def declare_actions(w: World) -> list[Action]:
    """Returns up to three actions with one to three arguments."""
    r, found = w.random, []
    for name in r.sample(NAMES, r.choice((0, 0, 1, 1, 2, 3))):
        names = r.sample(ARGUMENTS, 3)
        number = r.choice((1, 1, 1, 2, 2, 3))
        found.append(
            Action(
                name,
                tuple(
                    Argument(names[i] if r.random() < 0.6 else "", _type(w)) for i in range(number)
                ),
            )
        )
    return found


def _type(w: World) -> ir.Type:
    match w.random.choice(("agent", "word", "int")):
        case "agent":
            return ir.AGENT
        case "word":
            words = w.random.choice(w.word_sets)
            return ir.Type(
                kind="word",
                words=tuple(w.random.sample(words, min(len(words), w.random.randint(1, 2)))),
            )
        case _:
            low = w.random.choice((0, 0, 1, -1))
            return ir.Type(
                kind="int", unit="count", low=low, high=low + w.random.choice((0, 1, 1, 2))
            )


def _sort(type_: ir.Type) -> str:
    match type_.kind:
        case "word":
            return f"{{ {', '.join(type_.words)} }}"
        case "int":
            return f"{int(type_.low)} .. {int(type_.high)}"
        case _:
            return "agent"


def chosen(scope: Scope, v: Variable, depth: int) -> str:
    """Returns `v chose vote(x)`, `v chose vote`, or that with a condition on an argument; nothing without such actions."""
    w = scope.world
    if not w.with_arguments:
        return ""
    action = w.random.choice(w.with_arguments)
    if w.is_now(0.3):
        return f"{v.name} chose {action.name}"
    if w.is_now(0.4) and action.readable:
        argument = w.random.choice(action.readable)
        return f"({v.name} chose {action.name} and {_test(scope, action.read(v.name, argument), argument.type)})"
    return f"{v.name} chose {action.name}({', '.join(_asked(scope, a.type, depth, sure=False) for a in action.arguments)})"


def _test(scope: Scope, text: str, type_: ir.Type) -> str:
    match type_.kind:
        case "word":
            return f"{text} is {scope.world.random.choice(type_.words)}"
        case "int":
            return f"{text} {scope.world.random.choice(('<', '==', '>='))} {integer(scope, 'count', 1)[0]}"
        case _:
            return f"{text} {scope.world.random.choice(('is', 'is not'))} {scope.world.random.choice([*somebody(scope), *scope.nobodies(), text])}"


def _asked(scope: Scope, type_: ir.Type, depth: int, sure: bool) -> str:
    """Returns what an argument is asked to be; `sure`: surely one of its values, as a policy takes it."""
    w = scope.world
    match type_.kind:
        case "word":
            found = word(scope, type_.words, min(depth, 1)) if sure or w.is_now(0.7) else None
            return (
                found[0]
                if found and set(found[1]) <= set(type_.words)
                else w.random.choice(type_.words)
            )
        case "int":
            value = integer(scope, "count", min(depth, 1))
            if sure or w.is_now(0.5) or value[1].low == value[1].high:
                return fitted(value, type_.low, type_.high)
            return value[0]
        case _:
            return w.random.choice([*somebody(scope) * 3, "0"])


def number_chosen(scope: Scope, unit: str) -> Typed | None:
    """Returns a whole number that is an argument of what an agent chose, and another number if it chose something else."""
    found = [
        (v, a, argument)
        for v in scope.agents()
        for a in scope.world.with_arguments
        for argument in a.readable
        if argument.type.kind == "int"
    ]
    if not found or unit != "count" or scope.sort != "phase":
        return None
    v, action, argument = scope.world.random.choice(found)
    low, high = min(0, argument.type.low), max(0, argument.type.high)
    text = f"case {v.name} chose {action.name} {{ yes: {action.read(v.name, argument)}, no: 0 }}"
    return f"({text})", ir.Type(kind="int", unit="count", low=low, high=high)


def by_choice(scope: Scope, effect) -> Lines:
    """Returns a statement under `when x chose vote`, in which the arguments have names; nothing without such actions.

    `effect`: makes the statement, from a scope.
    """
    w = scope.world
    if not w.with_arguments or not scope.agents() or scope.sort != "phase":
        return []
    v, action = w.random.choice(scope.agents()), w.random.choice(w.with_arguments)
    lines, inner = Lines(), scope
    for argument in action.readable:
        read = action.read(v.name, argument)
        if argument.type.kind == "agent":
            inner = replace(inner, sure=inner.sure | {read})
        else:
            name = w.variable()
            lines.append(f"let {name} = {read}")
            inner = replace(
                inner, locals=(*inner.locals, (name, argument.type)), bound=inner.bound | {name}
            )
    return [
        f"when {v.name} chose {action.name} {{",
        *(f"  {line}" for line in (*lines, *effect(inner))),
        "}",
    ]


def forbidden(w: World) -> Lines:
    """Returns a `forbid` of an action with arguments, some of them named, some fixed."""
    if not w.with_arguments or w.is_now(0.4):
        return []
    action, scope, given = (
        w.random.choice(w.with_arguments),
        Scope(w, "forbid").having(Variable("agent")),
        [],
    )
    read = []
    for argument in action.arguments:
        if argument.type.kind == "word" or w.is_now(0.3):
            given.append(_fixed(w, argument.type))
            continue
        name = w.variable()
        given.append(name)
        if argument.type.kind == "agent":
            scope = scope.having(Variable(name))
            read.append(f"{name} {w.random.choice(('is', 'is not'))} agent")
        else:
            scope = replace(
                scope, locals=(*scope.locals, (name, argument.type)), bound=scope.bound | {name}
            )
            read.append(f"{name} > {integer(scope, 'count', 0)[0]}")
    test = condition(scope, 1)
    if read and w.is_now(0.7):
        test = f"{w.random.choice(read)} {w.random.choice(('and', 'or'))} ({test})"
    return [
        f"forbid {action.name}{'' if w.is_now(0.15) and not read else '(' + ', '.join(given) + ')'} when {test}"
    ]


def _fixed(w: World, type_: ir.Type) -> str:
    match type_.kind:
        case "word":
            return w.random.choice(type_.words)
        case "int":
            return str(w.random.randint(int(type_.low), int(type_.high)))
        case _:
            return "0"  # a variant may have fewer agents


def taken(scope: Scope) -> str:
    """Returns an action with arguments that a policy can take; nothing without one."""
    w = scope.world
    if not w.with_arguments:
        return ""
    action = w.random.choice(w.with_arguments)
    return (
        f"{action.name}({', '.join(_asked(scope, a.type, 1, sure=True) for a in action.arguments)})"
    )
