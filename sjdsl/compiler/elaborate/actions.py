"""Elaborates actions: their names and arguments, what rules ask about them, and the arguments that rules read.

acts stay, vote(agent)   ->   actions stay, vote(0), vote(1), …
"""

from itertools import product
from math import prod

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.arithmetic import join_types
from sjdsl.compiler.elaborate.fields import field_type
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, as_agent, check_known_word, check_somebody, not_a_word, not_named
from sjdsl.compiler.elaborate.scope import ALL_ACTIONS, Scope, wrong_type
from sjdsl.compiler.ir.implications import is_known, narrow_word, narrowed
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.types import describe
from sjdsl.runtime.actions import BUILT_IN

BETWEEN_STEPS = ("observe", "metrics", "checks", "policy")  # parts of a game that speak of a state, not of a step

# ---- declared


def declare_actions(game: Composition, scope: Scope) -> None:
    """Adds the actions to the tables, as far as the game says; needs the number of agents and the names of their fields."""
    if game.acts is None:
        return
    static, problems, flat = scope.static, scope.problems, list[str]()
    for action in game.acts.actions:
        name = action.name.text
        if name in static.action_names:
            problems.add(errors.WrittenTwice(action.name.span, what=f"the action `{name}`"))
            continue
        static.action_names.append(name)
        if not action.arguments:
            flat.append(name)
            continue
        with problems.survive():
            arguments = _arguments(action, game, scope)
            if len(flat) + prod(a.count for a in arguments) <= limits.MAX_ACTIONS:
                static.with_arguments[name] = ir.ActionWithArguments(name=name, first=len(flat), arguments=arguments, origin=action.span)
                flat += [f"{name}({', '.join(values)})" for values in product(*map(_values, arguments))]
                continue
            problems.add(errors.Unsupported(action.span, what=f"more than {limits.MAX_ACTIONS} actions"))
        static.broken_actions.add(name)
    if "stay" not in flat:
        problems.add(errors.MissingPart(game.acts.span, what="action `stay`", how="`stay` among the `acts`"))
    if len(flat) > limits.MAX_ACTIONS:
        problems.add(errors.Unsupported(game.acts.span, what=f"more than {limits.MAX_ACTIONS} actions"))
    static.actions = tuple(flat)


def _arguments(action: ast.Action, game: Composition, scope: Scope) -> tuple[ir.ActionArgument, ...]:
    name = action.name.text
    if name in BUILT_IN:
        raise scope.problems.fail(errors.WrongArguments(action.span, name=name, wanted="no arguments", given=len(action.arguments)))
    if name in AGENT_ATTRIBUTES or name in game.agent_fields:
        what = f"a field of the agents, and `agent.{name}` reads it"
        found = errors.NameTaken(action.name.span, name=name, what=what, help="give the action or the field another name")
        raise scope.problems.fail(found)
    names = [argument.name.text for argument in action.arguments if argument.name is not None]
    for number, argument in enumerate(action.arguments):
        if argument.name is not None and names.index(argument.name.text) < sum(a.name is not None for a in action.arguments[:number]):
            scope.problems.add(errors.WrittenTwice(argument.name.span, what=f"the argument `{argument.name.text}`"))
    return tuple(_argument(argument, name, scope) for argument in action.arguments)


def _argument(argument: ast.Argument, action: str, scope: Scope) -> ir.ActionArgument:
    type_ = field_type(argument.type, action, scope)
    capped = isinstance(argument.type, ast.Range) and argument.type.capped
    if type_.kind not in ("agent", "word", "int") or capped:
        given = f"{describe(type_)} that is `capped`" if capped else describe(type_)
        raise scope.problems.fail(errors.WrongType(argument.type.span, wanted="`agent`, a set of words or a range", given=given))
    counts = {"agent": scope.static.num_agents, "word": len(type_.words), "int": int(min(type_.high - type_.low, limits.MAX_ACTIONS)) + 1}
    name = "" if argument.name is None else argument.name.text
    return ir.ActionArgument(name=name, type=type_, count=counts[type_.kind], origin=argument.span)


def _values(argument: ir.ActionArgument) -> tuple[str, ...]:
    """Returns the values of an argument in the names of the actions, in order."""
    if argument.type.kind == "word":
        return argument.type.words
    low = int(argument.type.low) if argument.type.kind == "int" else 0
    return tuple(str(low + i) for i in range(argument.count))


# ---- asked about


def declared_action(action: ast.Chosen, name: str, scope: Scope) -> ir.ActionWithArguments | None:
    """Returns the declaration of an action with arguments, None for one without; says so if there is none of this name.

    `name`: what a phase's parameter stands for, or the name as written.
    """
    static = scope.static
    if ALL_ACTIONS in static.broken or name in static.broken_actions:
        raise Poisoned
    if name not in static.action_names:
        raise scope.problems.fail(errors.NoAction(action.name.span, name=name, near=near(name, static.action_names, "the actions")))
    if action.name.text in scope.variables:
        scope.refer(action.name)
    else:
        static.refer(action.name, Symbol("action", name))
    declared = static.with_arguments.get(name)
    given = 0 if action.arguments is None else len(action.arguments)
    wanted = 0 if declared is None else len(declared.arguments)
    if action.arguments is not None and given != wanted:
        counted = f"{wanted} argument{'s' * (wanted != 1)}"
        raise scope.problems.fail(errors.WrongArguments(action.span, name=name, wanted=counted, given=given))
    return declared


def check_in_step(said: str, span: Span, scope: Scope) -> None:
    """Says so if a part of the game that speaks of a state asks about what is done in a step."""
    if scope.part in BETWEEN_STEPS:
        what, wanted = "about what is done in a step", "something about a state"
        raise scope.problems.fail(errors.WrongSort(span, name=said, what=what, wanted=wanted))


def action_numbers(action: ast.Chosen, scope: Scope) -> tuple[int, ...]:
    """Returns the number of an action, or those of an action with arguments, whatever they are."""
    declared = declared_action(action, action.name.text, scope)
    return (scope.static.actions.index(action.name.text),) if declared is None else tuple(declared.numbers)


def chose(e: ast.Chose, agent: ir.Member, name: str, scope: Scope) -> ir.Expr:
    """Returns `x chose zap`, `x chose vote` or `x chose vote(y)`."""
    declared = declared_action(e.action, name, scope)
    if declared is None:
        return ir.Chose(agent=agent, action=scope.static.actions.index(name), origin=e.span)
    return ir.ChoseWith(agent=agent, action=name, given=arguments_given(e.action, declared, scope), origin=e.span)


def arguments_given(action: ast.Chosen, declared: ir.ActionWithArguments, scope: Scope) -> tuple[ir.Given, ...]:
    """Returns the arguments of an action that is asked about, none if none are written."""
    pairs = zip(action.arguments or (), declared.arguments, strict=False)
    return tuple(ir.Given(name=d.name, type=d.type, value=_asked(tree, d, action, scope), origin=tree.span) for tree, d in pairs)


def _asked(tree: ast.Expr, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope) -> ir.Expr:
    type_ = declared.type
    if type_.kind == "word":
        check_known_word(tree, action.name.text, type_.words, scope)
    value = scope.expression(tree)
    if isinstance(value, ir.Number) and type_.kind != "word" and not value.type.by:
        return _number(tree, value, declared, action, scope)
    match type_.kind:
        case "agent":
            if not as_agent(value) or isinstance(value, ir.Nobody):
                given = "nobody" if isinstance(value, ir.Nobody) else describe(value.type)
                raise scope.problems.fail(errors.WrongType(tree.span, wanted="an agent, or the number of one", given=given))
            check_somebody(value, tree.span, scope)
        case "int":
            if value.type.kind != "int" or value.type.by:
                raise wrong_type(scope, tree, "a whole number", value.type)
            join_types([type_, value.type], scope, "compare", tree)
        case _:
            value = narrow_word(value, scope.facts)
            if value.type.kind != "word" or value.type.by:
                raise wrong_type(scope, tree, describe(type_), value.type)
            if isinstance(value, ir.Word) and value.value not in type_.words:
                raise not_a_word(tree.span, value.value, action.name.text, type_.words, scope)
            if not set(value.type.words) & set(type_.words):
                raise scope.problems.fail(errors.NeverEqual(tree.span))
    return value


def _number(tree: ast.Expr, value: ir.Number, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope) -> ir.Expr:
    """Returns a number that is written, if it is one of the argument's; for an agent, the number of one."""
    what = f"the argument of `{action.name.text}`"
    low, high = (0, declared.count - 1) if declared.type.kind == "agent" else (declared.type.low, declared.type.high)
    if value.type.kind != "int":
        raise wrong_type(scope, tree, "a whole number", value.type)
    if not low <= value.value <= high:
        raise scope.problems.fail(errors.OutOfLimits(tree.span, name=what, value=value.value, low=low, high=high))
    return value


def fixed_argument(tree: ast.Expr, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope) -> int:
    """Returns which of its values an argument is that is written as a number or a word."""
    value = _asked(tree, declared, action, scope)
    if isinstance(value, ir.Word):
        return declared.type.words.index(value.value)
    if isinstance(value, ir.Number):
        return int(value.value - (declared.type.low if declared.type.kind == "int" else 0))
    raise scope.problems.fail(errors.NotFixed(tree.span, what="an argument that is no new name"))


def check_exists(given: tuple[ir.Given, ...], declared: ir.ActionWithArguments, scope: Scope) -> None:
    """Says so if an action that is to be taken may not exist: its arguments surely have the values that they are declared to have."""
    for asked, argument in zip(given, declared.arguments, strict=True):
        value, type_ = asked.value, argument.type
        if type_.kind == "int":
            low, high = narrowed(value, scope.facts_and_requires)
            if low < type_.low or high > type_.high:
                name = f"the argument of `{declared.name}`"
                reached = f"{low:g} .. {high:g}"
                raise scope.problems.fail(errors.OutOfLimits(asked.span, name=name, value=reached, low=type_.low, high=type_.high))
        elif type_.kind == "word":
            outside = [word for word in value.type.words if word not in type_.words]
            if outside:
                raise not_a_word(asked.span, outside[0], declared.name, type_.words, scope)


# ---- read


def argument_read(agent: ir.Expr, steps: tuple[ast.Member | ast.Index, ...], scope: Scope) -> tuple[ir.Expr, int]:
    """Returns what `agent.vote` or `agent.offer.apples` stands for, and how many of the steps of the path that takes."""
    assert isinstance(steps[0], ast.Member)
    declared = scope.static.with_arguments[steps[0].name.text]
    number, used = 0, 1
    if len(declared.arguments) > 1 or declared.arguments[0].name:
        number, used = _named(declared, steps, scope), 2
    scope.static.refer(steps[0].name, Symbol("action", declared.name))
    argument, last = declared.arguments[number], steps[used - 1]
    if not (isinstance(agent, ir.Member) and agent.sort.what == "agent"):
        raise not_named(agent, ast.Path(last.span, steps[0].name, ()), scope)
    read = ir.ArgumentOf(type=argument.type, agent=agent, action=declared.name, number=number, name=argument.name, origin=last.span)
    check_in_step(text(read), last.span, scope)
    if not is_known(ir.ChoseWith(agent=agent, action=declared.name), scope.facts):
        raise scope.problems.fail(errors.NotChosen(last.span, agent=text(agent), action=declared.name, path=text(read)))
    return read, used


def _named(declared: ir.ActionWithArguments, steps: tuple[ast.Member | ast.Index, ...], scope: Scope) -> int:
    names = [argument.name for argument in declared.arguments]
    if len(steps) > 1 and isinstance(steps[1], ast.Member) and steps[1].name.text in names:
        scope.static.refer(steps[1].name, Symbol("argument", steps[1].name.text, declared.name))
        return names.index(steps[1].name.text)
    named = [name for name in names if name]
    how = (
        f"`.{declared.name}.{named[0]}` is one of them" if named else f"give them names in `acts`: `{declared.name}(first : …, second : …)`"
    )
    if len(steps) > 1 and isinstance(steps[1], ast.Member):
        found = near(steps[1].name.text, named, "its arguments")
        raise scope.problems.fail(
            errors.NoField(steps[1].name.span, owner=f"the action `{declared.name}`", name=steps[1].name.text, near=found)
        )
    what = "an action with arguments"
    raise scope.problems.fail(errors.WrongSort(steps[0].span, name=declared.name, what=what, wanted="a value", help=how))
