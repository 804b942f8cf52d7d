"""Lowers what agents chose: numbers of actions, and the arguments of actions."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named
from sjdsl.compiler.lower.axes import TRUE, Value, as_dtype, literal
from sjdsl.compiler.lower.entries import ABSENT, to_words
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Expression, Name


def action_of(agent: ir.Expr, scope: IterationScope) -> Value:
    """Returns the number of the action that an agent takes in this step.

    In generated code, `actions` has the number of each agent's action: a variable that is each
    agent once, in order, reads all of it, and any other looks its agents up.
    """
    assert isinstance(agent, ir.Member), agent
    variable = scope.variables[agent.name]
    actions: Expression = Name("actions")
    is_each_agent = variable.axis is not None
    if not is_each_agent:
        actions = actions[variable.number.node]
    return Value(actions, "i32", variable.number.axes)


def chose_with(e: ir.ChoseWith, scope: IterationScope, w: Writer) -> Value:
    """Returns whether an agent chose an action with these arguments, or with any."""
    action = action_named(w.game, e.action)
    chosen_action = action_of(e.agent, scope)
    if e.given:
        number, exists = action_number(action, e.given, scope, w)
        return chosen_action.eq(number) & exists
    first = Value(w.module.first_action(action), "i32")
    if len(action.numbers) == 1:
        return chosen_action.eq(first)
    last = literal(action.numbers[-1], "i32")
    return (chosen_action >= first) & (chosen_action <= last)


def action_number(
    action: ir.ActionWithArguments, given: tuple[ir.Given, ...], scope: IterationScope, w: Writer
) -> tuple[Value, Value]:
    """Returns the number of an action with these arguments, and whether there is one.

    An action has a number for each combination of its arguments' values, the last argument fastest.
    """
    offset = literal(0, "i32")
    exists = TRUE
    for argument, declared in zip(given, action.arguments, strict=True):
        place, is_value = _place(argument, declared, scope, w)
        count = literal(declared.count, "i32")
        offset = offset * count + place
        exists = exists & is_value
    is_known = offset.literal and 0 <= offset.number < len(action.numbers)
    if is_known:
        return Value(w.module.action(action.first + int(offset.number)), "i32"), exists
    first = Value(w.module.first_action(action), "i32")
    return offset + first, exists


def _place(
    argument: ir.Given, declared: ir.ActionArgument, scope: IterationScope, w: Writer
) -> tuple[Value, Value]:
    """Returns the place of a value among those of an argument, and whether it is one of them."""
    value = w.value(argument.value, scope)
    type_ = argument.value.type
    match declared.type.kind:
        case "word":
            words = declared.type.words
            number = to_words(value, type_.words, words, w)
            exists = TRUE
            if not set(type_.words) <= set(words):
                exists = number.ne(ABSENT)
            return as_dtype(number, "i32"), exists
        case "int":
            low = literal(declared.type.low, "i32")
            high = declared.type.high
            value = as_dtype(value, "i32")
            exists = TRUE
            if type_.low < declared.type.low:
                exists = value >= low
            if type_.high > high:
                exists = exists & (value <= high)
            return value - low, exists
        case _:
            return as_dtype(value, "i32"), TRUE


def argument_of(e: ir.ArgumentOf, scope: IterationScope, w: Writer) -> Value:
    """Returns an argument of the action an agent chose.

    If it chose another action, the value means nothing, and no rule reads it.
    """
    action = action_named(w.game, e.action)
    first = Value(w.module.first_action(action), "i32")
    argument = action.arguments[e.number]
    # The number within the action counts its arguments up, the last one fastest.
    place = action_of(e.agent, scope) - first
    for later in reversed(action.arguments[e.number + 1 :]):
        place = place // later.count
    place = place % argument.count
    return argument_value(argument, w.keep(f"{e.action}_{e.name}".strip("_"), place))


def argument_value(argument: ir.ActionArgument, place: Value) -> Value:
    """Returns the value of an argument at a place among its values."""
    match argument.type.kind:
        case "word":
            return as_dtype(place, "u8")
        case "int":
            return place + argument.type.low
        case _:
            return place
