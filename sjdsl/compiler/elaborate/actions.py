"""Elaborates actions: their names and arguments, `chose`, arguments that rules read, `forbid`.

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
from sjdsl.compiler.elaborate.lookup import (
    AGENT_ATTRIBUTES,
    check_agent,
    check_arguments,
    check_free,
    check_known_word,
    check_words,
    named_agent,
    not_a_word,
    repeated,
)
from sjdsl.compiler.elaborate.possible import possible_condition
from sjdsl.compiler.elaborate.scope import ALL_ACTIONS, Scope, wrong_type
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.implications import is_known, narrow_word, narrowed
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.types import describe
from sjdsl.runtime.actions import BUILT_IN

BETWEEN_STEPS = ("observe", "metrics", "checks", "policy")  # parts about a state, not a step
TOO_MANY_ACTIONS = f"more than {limits.MAX_ACTIONS} actions"
ARGUMENT_TYPES = "`agent`, a set of words or a range"

# ---- declared


def declare_actions(game: Composition, scope: Scope) -> None:
    """Adds the actions to the tables; needs the number of agents and the names of their fields."""
    if game.acts is None:
        return
    static = scope.static
    problems = scope.problems
    actions: list[str] = []
    for action in game.acts.actions:
        name = action.name.text
        if name in static.action_names:
            problems.add(errors.WrittenTwice(action.name.span, part=f"the action `{name}`"))
            continue
        static.action_names.append(name)
        if not action.arguments:
            actions.append(name)
            continue
        with problems.skip_if_broken(static.broken_actions, name):
            declared = _with_arguments(action, len(actions), game, scope)
            static.with_arguments[name] = declared
            combinations = product(*map(_values, declared.arguments))
            actions += [f"{name}({', '.join(values)})" for values in combinations]
    if "stay" not in actions:
        example = "`stay` among the `acts`"
        problems.add(errors.MissingPart(game.acts.span, part="action `stay`", example=example))
    if len(actions) > limits.MAX_ACTIONS:
        problems.add(errors.Unsupported(game.acts.span, feature=TOO_MANY_ACTIONS))
    static.actions = tuple(actions)


def _with_arguments(
    action: ast.Action, first: int, game: Composition, scope: Scope
) -> ir.ActionWithArguments:
    """Returns an action with arguments. first: its first number."""
    name = action.name.text
    if name in BUILT_IN:
        check_arguments(name, action.span, len(action.arguments), 0, scope)
    if name in AGENT_ATTRIBUTES or name in game.agent_fields:
        raise scope.fail(
            errors.NameTaken(
                action.name.span,
                name=name,
                taken_by=f"a field of the agents, and `agent.{name}` reads it",
                help="give the action or the field another name",
            )
        )
    names = (argument.name for argument in action.arguments if argument.name is not None)
    for repeated_name in repeated(names):
        part = f"the argument `{repeated_name.text}`"
        scope.problems.add(errors.WrittenTwice(repeated_name.span, part=part))
    arguments = tuple(_argument(argument, scope) for argument in action.arguments)
    if first + prod(a.count for a in arguments) > limits.MAX_ACTIONS:
        raise scope.fail(errors.Unsupported(action.span, feature=TOO_MANY_ACTIONS))
    return ir.ActionWithArguments(name=name, first=first, arguments=arguments, origin=action.span)


def _argument(argument: ast.Argument, scope: Scope) -> ir.ActionArgument:
    """Returns the typed argument of an action."""
    type_ = field_type(argument.type, scope)
    match type_.kind:
        case "agent":
            count = scope.static.num_agents
        case "word":
            count = len(type_.words)
        case "int":
            count = int(min(type_.high - type_.low, limits.MAX_ACTIONS)) + 1
        case _:
            raise scope.expected(argument.type.span, ARGUMENT_TYPES, describe(type_))
    if isinstance(argument.type, ast.Range) and argument.type.capped:
        actual = f"{describe(type_)} that is `capped`"
        raise scope.expected(argument.type.span, ARGUMENT_TYPES, actual)
    name = "" if argument.name is None else argument.name.text
    return ir.ActionArgument(name=name, type=type_, count=count, origin=argument.span)


def _values(argument: ir.ActionArgument) -> tuple[str, ...]:
    """Returns the values of an argument as the names of actions show them, in order."""
    if argument.type.kind == "word":
        return argument.type.words
    low = int(argument.type.low) if argument.type.kind == "int" else 0
    return tuple(str(low + i) for i in range(argument.count))


# ---- asked about


def declared_action(action: ast.Chosen, name: str, scope: Scope) -> ir.ActionWithArguments | None:
    """Returns the declaration of an action with arguments, None for one without.

    Reports a name that no action has. name: as written, or what a phase's parameter stands for.
    """
    static = scope.static
    if ALL_ACTIONS in static.broken or name in static.broken_actions:
        raise Poisoned
    if name not in static.action_names:
        meant = near(name, static.action_names, "the actions")
        raise scope.fail(errors.NoAction(action.name.span, name=name, near=meant))
    if action.name.text in scope.variables:
        scope.refer(action.name)
    else:
        static.refer(action.name, Symbol("action", name))
    declared = static.with_arguments.get(name)
    if action.arguments is not None:
        wanted = 0 if declared is None else len(declared.arguments)
        check_arguments(name, action.span, len(action.arguments), wanted, scope)
    return declared


def check_in_step(question: str, span: Span, scope: Scope) -> None:
    """Reports a question about an action, in a part of the game that is about a state."""
    if scope.part in BETWEEN_STEPS:
        value = question
        if " chose " in question:
            value = f"case {question} {{ yes: used, no: rested }}"
        raise scope.fail(
            errors.WrongSort(
                span,
                name=question,
                actual="about what happens in a step",
                wanted="something about a state",
                help=f"a rule can keep it in a field: `set agent.last = {value}`",
            )
        )


def action_numbers(action: ast.Chosen, scope: Scope) -> tuple[int, ...]:
    """Returns the number of an action; all of them, for an action with arguments."""
    declared = declared_action(action, action.name.text, scope)
    if declared is not None:
        return tuple(declared.numbers)
    return (scope.static.actions.index(action.name.text),)


def chose(e: ast.Chose, agent: ir.Member, name: str, scope: Scope) -> ir.Expr:
    """Returns `x chose zap`, `x chose vote` or `x chose vote(y)`."""
    declared = declared_action(e.action, name, scope)
    if declared is None:
        return ir.Chose(agent=agent, action=scope.static.actions.index(name), origin=e.span)
    given = arguments_given(e.action, declared, scope)
    return ir.ChoseWith(agent=agent, action=name, given=given, origin=e.span)


def arguments_given(
    action: ast.Chosen, declared: ir.ActionWithArguments, scope: Scope
) -> tuple[ir.Given, ...]:
    """Returns the arguments that are written after an action, none if there are none."""
    pairs = zip(action.arguments or (), declared.arguments, strict=False)
    return tuple(
        ir.Given(
            name=argument.name,
            type=argument.type,
            value=_argument_value(tree, argument, action, scope),
            origin=tree.span,
        )
        for tree, argument in pairs
    )


def _argument_value(
    tree: ast.Expr, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope
) -> ir.Expr:
    """Returns a value that an argument can have; an agent may be written as its number."""
    type_ = declared.type
    name = action.name.text
    if type_.kind == "word":
        check_known_word(tree, name, type_.words, scope)
    value = scope.expression(tree)
    if isinstance(value, ir.Number) and type_.kind != "word" and not value.type.indexed_by:
        _check_argument_number(value, tree, declared, name, scope)
        return value
    match type_.kind:
        case "agent":
            check_agent(value, tree, "an agent, or the number of one", scope)
        case "int":
            if not value.type.is_single("int"):
                raise wrong_type(scope, tree, "a whole number", value.type)
            join_types([type_, value.type], scope, "compare", tree)
        case _:
            value = narrow_word(value, scope.facts)
            if not value.type.is_single("word"):
                raise wrong_type(scope, tree, describe(type_), value.type)
            if isinstance(value, ir.Word):
                check_words((value.value,), type_.words, tree.span, name, scope)
            if not set(value.type.words) & set(type_.words):
                raise scope.fail(errors.NeverEqual(tree.span))
    return value


def _check_argument_number(
    number: ir.Number, tree: ast.Expr, declared: ir.ActionArgument, action: str, scope: Scope
) -> None:
    """Reports a number that an argument, or the number of an agent, can't be."""
    if number.type.kind != "int":
        raise wrong_type(scope, tree, "a whole number", number.type)
    low: float = 0
    high: float = declared.count - 1
    if declared.type.kind == "int":
        low = declared.type.low
        high = declared.type.high
    if not low <= number.value <= high:
        name = f"the argument of `{action}`"
        raise scope.fail(
            errors.OutOfLimits(tree.span, name=name, value=number.value, low=low, high=high)
        )


def fixed_argument(
    tree: ast.Expr, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope
) -> int:
    """Returns the place of a number or word among the values of an argument."""
    value = _argument_value(tree, declared, action, scope)
    if isinstance(value, ir.Word):
        return declared.type.words.index(value.value)
    if isinstance(value, ir.Number):
        lowest = declared.type.low if declared.type.kind == "int" else 0
        return int(value.value - lowest)
    raise scope.fail(errors.NotFixed(tree.span, quantity="an argument that isn't a new name"))


def check_exists(
    given: tuple[ir.Given, ...], declared: ir.ActionWithArguments, scope: Scope
) -> None:
    """Reports an action to be taken that may not exist.

    Its arguments may have values other than those declared.
    """
    for argument, declared_argument in zip(given, declared.arguments, strict=True):
        type_ = declared_argument.type
        if type_.kind == "int":
            low, high = narrowed(argument.value, scope.facts_and_requires)
            if low < type_.low or high > type_.high:
                raise scope.fail(
                    errors.OutOfLimits(
                        argument.span,
                        name=f"the argument of `{declared.name}`",
                        value=f"{low:g} .. {high:g}",
                        low=type_.low,
                        high=type_.high,
                    )
                )
        elif type_.kind == "word":
            words = argument.value.type.words
            check_words(words, type_.words, argument.span, declared.name, scope)


# ---- read


def argument_read(
    agent: ir.Expr, steps: tuple[ast.Member | ast.Index, ...], scope: Scope
) -> tuple[ir.Expr, int]:
    """Returns `agent.vote` or `agent.offer.apples`, and how many steps of the path it takes."""
    assert isinstance(steps[0], ast.Member)
    declared = scope.static.with_arguments[steps[0].name.text]
    number = 0
    used = 1
    if len(declared.arguments) > 1 or declared.arguments[0].name:
        number = _argument_named(declared, steps, scope)
        used = 2
    scope.static.refer(steps[0].name, Symbol("action", declared.name))
    argument = declared.arguments[number]
    span = steps[used - 1].span
    agent = named_agent(agent, ast.Path(span, steps[0].name, ()), scope)
    read = ir.ArgumentOf(
        type=argument.type,
        agent=agent,
        action=declared.name,
        number=number,
        name=argument.name,
        origin=span,
    )
    check_in_step(text(read), span, scope)
    if not is_known(ir.ChoseWith(agent=agent, action=declared.name), scope.facts):
        raise scope.fail(
            errors.NotChosen(span, agent=text(agent), action=declared.name, path=text(read))
        )
    return read, used


def _argument_named(
    declared: ir.ActionWithArguments, steps: tuple[ast.Member | ast.Index, ...], scope: Scope
) -> int:
    """Returns the place of the argument that the second step of a path names."""
    action = declared.name
    names = [argument.name for argument in declared.arguments]
    named = [name for name in names if name]
    if len(steps) > 1 and isinstance(steps[1], ast.Member):
        name = steps[1].name
        if name.text in names:
            scope.static.refer(name, Symbol("argument", name.text, action))
            return names.index(name.text)
        meant = near(name.text, named, "its arguments")
        raise scope.fail(
            errors.NoField(name.span, owner=f"the action `{action}`", name=name.text, near=meant)
        )
    help_ = f"give them names in `acts`: `{action}(first : …, second : …)`"
    if named:
        help_ = f"`.{action}.{named[0]}` is one of them"
    raise scope.fail(
        errors.WrongSort(
            steps[0].span,
            name=action,
            actual="an action with arguments",
            wanted="a value",
            help=help_,
        )
    )


# ---- forbidden


def forbids(game: Composition, scope: Scope) -> tuple[ir.Forbid, ...]:
    """Returns the `forbid` lines, which may read the agent's own fields and the world's."""
    return tuple(scope.problems.each(game.forbids.values(), lambda forbid: _forbid(forbid, scope)))


def _forbid(forbid: ast.Forbid, scope: Scope) -> ir.Forbid:
    """Returns a typed `forbid`."""
    numbers: list[int] = []
    names: dict[int, ast.Name] = {}  # of arguments, by place; only a single action has some
    declared: ir.ActionWithArguments | None = None
    for chosen in forbid.actions:
        declared = _forbidden_action(chosen, scope)
        if declared is None:
            numbers.append(scope.static.actions.index(chosen.name.text))
            continue
        names = _new_names(chosen, declared, scope)
        if names and len(forbid.actions) > 1:
            wanted = "a number or a word where `forbid` lists several actions"
            first_name, *_ = names.values()
            raise scope.misused(first_name, "a name for an argument", wanted)
        numbers += _forbidden_numbers(chosen, declared, names, scope)
    inner = scope
    if declared is not None and names:
        inner = _with_names(names, declared, scope)
    test = possible_condition(forbid.condition, inner)
    for node in ir.walk(test):
        if ir.is_expression(node) and _is_out_of_sight(node):
            span = node.origin or forbid.span
            raise scope.fail(errors.ForbidReads(span, reads=f"`{text(node)}`"))
    action = ""
    names_by_place: list[str] = []
    if declared is not None and names:
        _check_names_read(names, declared, test, scope)
        action = declared.name
        names_by_place = [""] * len(declared.arguments)
        for place, name in names.items():
            names_by_place[place] = name.text
    return ir.Forbid(
        actions=tuple(numbers or range(len(scope.static.actions))),
        condition=test,
        action=action,
        names=tuple(names_by_place),
        origin=forbid.span,
    )


def _forbidden_action(chosen: ast.Chosen, scope: Scope) -> ir.ActionWithArguments | None:
    """Returns the declaration of a forbidden action with arguments, None for one without."""
    if chosen.name.text == "stay":
        actual = "what forbidden actions become"
        raise scope.misused(chosen.name, actual, "an action that can be forbidden")
    return declared_action(chosen, chosen.name.text, scope)


def _new_names(
    chosen: ast.Chosen, declared: ir.ActionWithArguments, scope: Scope
) -> dict[int, ast.Name]:
    """Returns the names that `forbid` gives to arguments, by place: those that mean nothing yet."""
    known = scope.static.names() | set(scope.variables)
    names = {}
    for i, tree in enumerate(chosen.arguments or ()):
        if isinstance(tree, ast.Path) and not tree.steps:
            name = tree.name.text
            if name not in declared.arguments[i].type.words and name not in known:
                names[i] = tree.name
    return names


def _forbidden_numbers(
    chosen: ast.Chosen,
    declared: ir.ActionWithArguments,
    names: dict[int, ast.Name],
    scope: Scope,
) -> list[int]:
    """Returns the numbers of an action with the arguments that are written as values."""
    fixed = {
        i: fixed_argument(tree, declared.arguments[i], chosen, scope)
        for i, tree in enumerate(chosen.arguments or ())
        if i not in names
    }
    combinations = product(*(range(argument.count) for argument in declared.arguments))
    return [
        number
        for number, values in zip(declared.numbers, combinations, strict=True)
        if all(values[i] == value for i, value in fixed.items())
    ]


def _with_names(
    names: dict[int, ast.Name], declared: ir.ActionWithArguments, scope: Scope
) -> Scope:
    """Returns the scope of a `forbid`, in which names stand for the arguments of the action."""
    for i, name in names.items():
        check_free(name, scope, chosen=True)
        type_ = declared.arguments[i].type
        variable: ir.Expr = ir.Local(type=type_, name=name.text)
        if type_.kind == "agent":
            variable = ir.Member(name=name.text, entity_type=AGENTS)
        scope = scope.bind_named(name, variable)
    return scope


def _check_names_read(
    names: dict[int, ast.Name], declared: ir.ActionWithArguments, test: ir.Expr, scope: Scope
) -> None:
    """Reports a name for an argument of words that the condition doesn't read: a misspelt word."""
    read = {variable.name for variable in free_variables(test)}
    for i, name in names.items():
        type_ = declared.arguments[i].type
        if type_.kind == "word" and name.text not in read:
            raise not_a_word(name.span, name.text, declared.name, type_.words, scope)


def _is_out_of_sight(node: ir.Node) -> bool:
    """Returns whether `forbid` cannot read an expression.

    Such are places, other agents, and what is done in the step.
    """
    if isinstance(node, ir.Aggregate):
        return True
    match node:
        case ir.StandsOn() | ir.StandsAt() | ir.Chose() | ir.ChoseWith():
            return True
        case ir.Distance() | ir.Bearing():
            return True
        case ir.Attribute(name="row" | "col"):
            return True
        case ir.FieldRead():
            return node.held_by.what == "agent" and not isinstance(node.owner, ir.Member)
        case _:
            return False
