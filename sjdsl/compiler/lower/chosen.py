"""Lowers what agents chose: the number of their action, what an action with arguments is asked, and the arguments that rules read."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named
from sjdsl.compiler.lower.axes import TRUE, Value, as_dtype, binary, both, literal
from sjdsl.compiler.lower.entries import ABSENT, to_words
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array


def action_of(agent: ir.Expr, scope: IterationScope) -> Value:
    """Returns the number of the action an agent takes in this step."""
    assert isinstance(agent, ir.Member), agent
    who, actions = scope.variables[agent.name], array.Name("actions")
    return Value(
        actions if who.axis is not None else array.Index(actions, (who.number.node,)),
        "i32",
        who.number.axes,
    )


def chose_with(e: ir.ChoseWith, scope: IterationScope, w: Writer) -> Value:
    """Returns whether an agent chose an action with these arguments, or with any."""
    action = action_named(w.module.game, e.action)
    taken = action_of(e.agent, scope)
    if e.given:
        number, possible = action_number(action, e.given, scope, w)
        return both(binary("==", taken, number, "bool"), possible)
    first = Value(w.module.first_action(action), "i32")
    if len(action.numbers) == 1:
        return binary("==", taken, first, "bool")
    last = literal(action.numbers[-1], "i32")
    return both(binary(">=", taken, first, "bool"), binary("<=", taken, last, "bool"))


def action_number(
    action: ir.ActionWithArguments, given: tuple[ir.Given, ...], scope: IterationScope, w: Writer
) -> tuple[Value, Value]:
    """Returns the number of an action with these arguments, and whether there is one."""
    offset, possible = literal(0, "i32"), TRUE
    for asked, argument in zip(given, action.arguments, strict=True):
        at, exists = _place(asked, argument, scope, w)
        offset = binary("+", binary("*", offset, literal(argument.count, "i32"), "i32"), at, "i32")
        possible = both(possible, exists)
    if offset.literal and 0 <= offset.number < len(action.numbers):  # else it is not possible
        return Value(w.module.action(action.first + int(offset.number)), "i32"), possible
    return binary("+", offset, Value(w.module.first_action(action), "i32"), "i32"), possible


def _place(
    asked: ir.Given, argument: ir.ActionArgument, scope: IterationScope, w: Writer
) -> tuple[Value, Value]:
    """Returns which of the values of an argument is asked for, and whether it is one of them."""
    value, type_ = w.value(asked.value, scope), asked.value.type
    match argument.type.kind:
        case "word":
            inside = set(type_.words) <= set(argument.type.words)
            number = to_words(value, type_.words, argument.type.words, w)
            exists = TRUE if inside else binary("!=", number, literal(ABSENT, "u8"), "bool")
            return as_dtype(number, "i32"), exists
        case "int":
            low, high = argument.type.low, argument.type.high
            value = as_dtype(value, "i32")
            tests = [] if type_.low >= low else [binary(">=", value, literal(low, "i32"), "bool")]
            tests += (
                [] if type_.high <= high else [binary("<=", value, literal(high, "i32"), "bool")]
            )
            return binary("-", value, literal(low, "i32"), "i32"), both(*tests)
        case _:
            return as_dtype(value, "i32"), TRUE


def argument_of(e: ir.ArgumentOf, scope: IterationScope, w: Writer) -> Value:
    """Returns an argument of the action an agent chose; of another action's number some value of the argument, which no rule looks at."""
    action = action_named(w.module.game, e.action)
    offset = binary(
        "-", action_of(e.agent, scope), Value(w.module.first_action(action), "i32"), "i32"
    )
    for argument in reversed(action.arguments[e.number + 1 :]):
        offset = binary("//", offset, literal(argument.count, "i32"), "i32")
    argument = action.arguments[e.number]
    at = binary("%", offset, literal(argument.count, "i32"), "i32")
    return argument_value(argument, w.keep(f"{e.action}_{e.name}".strip("_"), at))


def argument_value(argument: ir.ActionArgument, at: Value) -> Value:
    """Returns a value of an argument, from which of them it is."""
    if argument.type.kind == "word":
        return as_dtype(at, "u8")
    return (
        binary("+", at, literal(argument.type.low, "i32"), "i32")
        if argument.type.kind == "int"
        else at
    )
