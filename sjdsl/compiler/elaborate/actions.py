"""Elaborates actions: their names and arguments, what rules ask about them, the arguments that rules read, and `forbid`.

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
    as_agent,
    check_arguments,
    check_free,
    check_known_word,
    check_somebody,
    check_words,
    not_a_word,
    not_named,
)
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import ALL_ACTIONS, Scope, wrong_type
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.implications import is_known, narrow_word, narrowed
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.ir.types import describe
from sjdsl.runtime.actions import BUILT_IN

BETWEEN_STEPS = (
    "observe",
    "metrics",
    "checks",
    "policy",
)  # parts of a game that speak of a state, not of a step

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
                static.with_arguments[name] = ir.ActionWithArguments(
                    name=name, first=len(flat), arguments=arguments, origin=action.span
                )
                flat += [
                    f"{name}({', '.join(values)})" for values in product(*map(_values, arguments))
                ]
                continue
            problems.add(
                errors.Unsupported(action.span, what=f"more than {limits.MAX_ACTIONS} actions")
            )
        static.broken_actions.add(name)
    if "stay" not in flat:
        problems.add(
            errors.MissingPart(game.acts.span, what="action `stay`", how="`stay` among the `acts`")
        )
    if len(flat) > limits.MAX_ACTIONS:
        problems.add(
            errors.Unsupported(game.acts.span, what=f"more than {limits.MAX_ACTIONS} actions")
        )
    static.actions = tuple(flat)


def _arguments(
    action: ast.Action, game: Composition, scope: Scope
) -> tuple[ir.ActionArgument, ...]:
    name = action.name.text
    if name in BUILT_IN:
        raise scope.fail(
            errors.WrongArguments(
                action.span, name=name, wanted="no arguments", given=len(action.arguments)
            )
        )
    if name in AGENT_ATTRIBUTES or name in game.agent_fields:
        what = f"a field of the agents, and `agent.{name}` reads it"
        raise scope.fail(
            errors.NameTaken(
                action.name.span,
                name=name,
                what=what,
                help="give the action or the field another name",
            )
        )
    names = [argument.name for argument in action.arguments if argument.name is not None]
    for number, argument in enumerate(names):
        if argument.text in [other.text for other in names[:number]]:
            scope.problems.add(
                errors.WrittenTwice(argument.span, what=f"the argument `{argument.text}`")
            )
    return tuple(_argument(argument, scope) for argument in action.arguments)


def _argument(argument: ast.Argument, scope: Scope) -> ir.ActionArgument:
    type_ = field_type(argument.type, scope)
    capped = isinstance(argument.type, ast.Range) and argument.type.capped
    if type_.kind not in ("agent", "word", "int") or capped:
        given = f"{describe(type_)} that is `capped`" if capped else describe(type_)
        raise scope.fail(
            errors.WrongType(
                argument.type.span, wanted="`agent`, a set of words or a range", given=given
            )
        )
    counts = {
        "agent": scope.static.num_agents,
        "word": len(type_.words),
        "int": int(min(type_.high - type_.low, limits.MAX_ACTIONS)) + 1,
    }
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
    """Returns the declaration of an action with arguments, None for one without; reports a name that no action has.

    `name`: what a phase's parameter stands for, or the name as written.
    """
    static = scope.static
    if ALL_ACTIONS in static.broken or name in static.broken_actions:
        raise Poisoned
    if name not in static.action_names:
        raise scope.fail(
            errors.NoAction(
                action.name.span, name=name, near=near(name, static.action_names, "the actions")
            )
        )
    if action.name.text in scope.variables:
        scope.refer(action.name)
    else:
        static.refer(action.name, Symbol("action", name))
    declared = static.with_arguments.get(name)
    if action.arguments is not None:
        check_arguments(
            name,
            action.span,
            len(action.arguments),
            0 if declared is None else len(declared.arguments),
            scope,
        )
    return declared


def check_in_step(question: str, span: Span, scope: Scope) -> None:
    """Reports a question about what is done in a step, in a part of the game that speaks of a state."""
    if scope.part in BETWEEN_STEPS:
        what, wanted = "about what happens in a step", "something about a state"
        kept = f"case {question} {{ yes: used, no: rested }}" if " chose " in question else question
        help_ = f"a rule can keep it in a field: `set agent.last = {kept}`"
        raise scope.fail(
            errors.WrongSort(span, name=question, what=what, wanted=wanted, help=help_)
        )


def action_numbers(action: ast.Chosen, scope: Scope) -> tuple[int, ...]:
    """Returns the number of an action, or those of an action with arguments, whatever they are."""
    declared = declared_action(action, action.name.text, scope)
    return (
        (scope.static.actions.index(action.name.text),)
        if declared is None
        else tuple(declared.numbers)
    )


def chose(e: ast.Chose, agent: ir.Member, name: str, scope: Scope) -> ir.Expr:
    """Returns `x chose zap`, `x chose vote` or `x chose vote(y)`."""
    declared = declared_action(e.action, name, scope)
    if declared is None:
        return ir.Chose(agent=agent, action=scope.static.actions.index(name), origin=e.span)
    return ir.ChoseWith(
        agent=agent, action=name, given=arguments_given(e.action, declared, scope), origin=e.span
    )


def arguments_given(
    action: ast.Chosen, declared: ir.ActionWithArguments, scope: Scope
) -> tuple[ir.Given, ...]:
    """Returns the arguments of an action that is asked about, none if none are written."""
    pairs = zip(action.arguments or (), declared.arguments, strict=False)
    return tuple(
        ir.Given(name=d.name, type=d.type, value=_asked(tree, d, action, scope), origin=tree.span)
        for tree, d in pairs
    )


def _asked(
    tree: ast.Expr, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope
) -> ir.Expr:
    type_, name = declared.type, action.name.text
    if type_.kind == "word":
        check_known_word(tree, name, type_.words, scope)
    value = scope.expression(tree)
    if (
        isinstance(value, ir.Number) and type_.kind != "word" and not value.type.by
    ):  # one of the argument's; for an agent, its number
        low, high = (0, declared.count - 1) if type_.kind == "agent" else (type_.low, type_.high)
        if value.type.kind != "int":
            raise wrong_type(scope, tree, "a whole number", value.type)
        if not low <= value.value <= high:
            raise scope.fail(
                errors.OutOfLimits(
                    tree.span,
                    name=f"the argument of `{name}`",
                    value=value.value,
                    low=low,
                    high=high,
                )
            )
        return value
    match type_.kind:
        case "agent":
            if not as_agent(value) or isinstance(value, ir.Nobody):
                given = "nobody" if isinstance(value, ir.Nobody) else describe(value.type)
                raise scope.fail(
                    errors.WrongType(
                        tree.span, wanted="an agent, or the number of one", given=given
                    )
                )
            check_somebody(value, tree.span, scope)
        case "int":
            if value.type.kind != "int" or value.type.by:
                raise wrong_type(scope, tree, "a whole number", value.type)
            join_types([type_, value.type], scope, "compare", tree)
        case _:
            value = narrow_word(value, scope.facts)
            if value.type.kind != "word" or value.type.by:
                raise wrong_type(scope, tree, describe(type_), value.type)
            if isinstance(value, ir.Word):
                check_words((value.value,), type_.words, tree.span, name, scope)
            if not set(value.type.words) & set(type_.words):
                raise scope.fail(errors.NeverEqual(tree.span))
    return value


def fixed_argument(
    tree: ast.Expr, declared: ir.ActionArgument, action: ast.Chosen, scope: Scope
) -> int:
    """Returns which of its values an argument is that is written as a number or a word."""
    value = _asked(tree, declared, action, scope)
    if isinstance(value, ir.Word):
        return declared.type.words.index(value.value)
    if isinstance(value, ir.Number):
        return int(value.value - (declared.type.low if declared.type.kind == "int" else 0))
    raise scope.fail(errors.NotFixed(tree.span, what="an argument that isn't a new name"))


def check_exists(
    given: tuple[ir.Given, ...], declared: ir.ActionWithArguments, scope: Scope
) -> None:
    """Reports an action that is to be taken and may not exist: its arguments may have values other than those declared."""
    for asked, argument in zip(given, declared.arguments, strict=True):
        type_ = argument.type
        if type_.kind == "int":
            low, high = narrowed(asked.value, scope.facts_and_requires)
            if low < type_.low or high > type_.high:
                name, reached = f"the argument of `{declared.name}`", f"{low:g} .. {high:g}"
                raise scope.fail(
                    errors.OutOfLimits(
                        asked.span, name=name, value=reached, low=type_.low, high=type_.high
                    )
                )
        elif type_.kind == "word":
            check_words(asked.value.type.words, type_.words, asked.span, declared.name, scope)


# ---- read


def argument_read(
    agent: ir.Expr, steps: tuple[ast.Member | ast.Index, ...], scope: Scope
) -> tuple[ir.Expr, int]:
    """Returns what `agent.vote` or `agent.offer.apples` stands for, and how many of the steps of the path that takes."""
    assert isinstance(steps[0], ast.Member)
    declared = scope.static.with_arguments[steps[0].name.text]
    number, used = 0, 1
    if len(declared.arguments) > 1 or declared.arguments[0].name:
        number, used = _argument_named(declared, steps, scope), 2
    scope.static.refer(steps[0].name, Symbol("action", declared.name))
    argument, last = declared.arguments[number], steps[used - 1]
    if not (isinstance(agent, ir.Member) and agent.sort.what == "agent"):
        raise not_named(agent, ast.Path(last.span, steps[0].name, ()), scope)
    read = ir.ArgumentOf(
        type=argument.type,
        agent=agent,
        action=declared.name,
        number=number,
        name=argument.name,
        origin=last.span,
    )
    check_in_step(text(read), last.span, scope)
    if not is_known(ir.ChoseWith(agent=agent, action=declared.name), scope.facts):
        raise scope.fail(
            errors.NotChosen(last.span, agent=text(agent), action=declared.name, path=text(read))
        )
    return read, used


def _argument_named(
    declared: ir.ActionWithArguments, steps: tuple[ast.Member | ast.Index, ...], scope: Scope
) -> int:
    """Returns the place of the argument that the second step of a path names."""
    names = [argument.name for argument in declared.arguments]
    named, action = [name for name in names if name], declared.name
    if len(steps) > 1 and isinstance(steps[1], ast.Member):
        name = steps[1].name
        if name.text in names:
            scope.static.refer(name, Symbol("argument", name.text, action))
            return names.index(name.text)
        meant = near(name.text, named, "its arguments")
        raise scope.fail(
            errors.NoField(name.span, owner=f"the action `{action}`", name=name.text, near=meant)
        )
    how = (
        f"`.{action}.{named[0]}` is one of them"
        if named
        else f"give them names in `acts`: `{action}(first : …, second : …)`"
    )
    raise scope.fail(
        errors.WrongSort(
            steps[0].span, name=action, what="an action with arguments", wanted="a value", help=how
        )
    )


# ---- forbidden


def forbids(game: Composition, scope: Scope) -> tuple[ir.Forbid, ...]:
    """Returns the `forbid` lines, which may read the agent's own fields and the world's."""
    return tuple(scope.problems.each(game.forbids.values(), lambda forbid: _forbid(forbid, scope)))


def _forbid(forbid: ast.Forbid, scope: Scope) -> ir.Forbid:
    static = scope.static
    numbers: list[int] = []
    new_words: dict[str, tuple[ast.Name, ir.ActionArgument]] = {}
    inner, with_names, names = scope, "", tuple[str, ...]()
    for chosen in forbid.actions:
        action = chosen.name.text
        if action == "stay":
            what, wanted = "what forbidden actions become", "an action that can be forbidden"
            raise scope.fail(
                errors.WrongSort(chosen.name.span, name=action, what=what, wanted=wanted)
            )
        declared = declared_action(chosen, action, scope)
        if declared is None:
            numbers.append(static.actions.index(action))
            continue
        bound: dict[int, ast.Name] = {}  # names for arguments: those that mean nothing else
        for i, tree in enumerate(chosen.arguments or ()):
            if (
                isinstance(tree, ast.Path)
                and not tree.steps
                and tree.name.text not in declared.arguments[i].type.words
            ):
                if tree.name.text not in static.names() | set(scope.variables):
                    bound[i] = tree.name
        if bound and len(forbid.actions) > 1:
            what, wanted = (
                "a name for an argument",
                "a number or a word where `forbid` lists several actions",
            )
            first = next(iter(bound.values()))
            raise scope.fail(
                errors.WrongSort(first.span, name=first.text, what=what, wanted=wanted)
            )
        fixed = {
            i: fixed_argument(tree, declared.arguments[i], chosen, scope)
            for i, tree in enumerate(chosen.arguments or ())
            if i not in bound
        }
        combinations = product(*(range(argument.count) for argument in declared.arguments))
        numbers += [
            n
            for n, values in zip(declared.numbers, combinations, strict=True)
            if all(values[i] == at for i, at in fixed.items())
        ]
        if bound:
            with_names, names = (
                action,
                tuple(bound[i].text if i in bound else "" for i in range(len(declared.arguments))),
            )
        for i, name in bound.items():
            check_free(name, inner, chosen=True)
            argument = declared.arguments[i]
            variable: ir.Expr = ir.Local(type=argument.type, name=name.text)
            if argument.type.kind == "agent":
                variable = ir.Member(name=name.text, sort=AGENTS)
            inner = inner.bind_named(name, variable)
            if argument.type.kind == "word":
                new_words[name.text] = (name, argument)
    test = inner.condition(forbid.condition)
    check_possible(test, inner)
    for node in ir.walk(test):
        if ir.is_expression(node) and _is_out_of_sight(node):
            raise scope.fail(errors.ForbidReads(node.origin or forbid.span, what=f"`{text(node)}`"))
    read = {variable.name for variable in free_variables(test)}
    for word, (written, argument) in new_words.items():
        if word not in read:  # a word that is misspelt looks like a new name
            raise not_a_word(written.span, word, with_names, argument.type.words, scope)
    numbers = numbers or list(range(len(static.actions)))
    return ir.Forbid(
        actions=tuple(numbers), condition=test, action=with_names, names=names, origin=forbid.span
    )


def _is_out_of_sight(node: ir.Node) -> bool:
    """Returns whether a `forbid` cannot read this: places, other agents, and what is done in the step."""
    if isinstance(node, ir.Aggregate):
        return True
    match node:
        case ir.StandsOn() | ir.StandsAt() | ir.Chose() | ir.ChoseWith() | ir.Distance():
            return True
        case ir.Attribute(name="row" | "col"):
            return True
        case ir.FieldRead():
            return node.held_by.what == "agent" and not isinstance(node.owner, ir.Member)
        case _:
            return False
