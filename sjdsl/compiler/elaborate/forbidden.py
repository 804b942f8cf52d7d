"""Elaborates `forbid`: which actions, and under which condition on the agent, the world and the arguments of an action."""

from itertools import product

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.actions import declared_action, fixed_argument
from sjdsl.compiler.elaborate.lookup import check_free, not_a_word
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.printer import expression as text


def forbids(game: Composition, static: Static, problems: Problems) -> tuple[ir.Forbid, ...]:
    """Returns the `forbid` lines, which may read the agent's own fields and the world's."""
    found = []
    scope = Scope(static, problems, part="forbid").bind("agent", ir.Member(name="agent", sort=ir.Sort("agent")))
    for forbid in game.forbids.values():
        with problems.survive():
            found.append(_forbid(forbid, scope))
    return tuple(found)


def _forbid(forbid: ast.Forbid, scope: Scope) -> ir.Forbid:
    numbers: list[int] = []
    named: dict[str, tuple[ast.Name, ir.ActionArgument]] = {}
    inner, action, names = scope, "", tuple[str, ...]()
    for chosen in forbid.actions:
        declared = _declared(chosen, scope)
        if declared is None:
            numbers.append(scope.static.actions.index(chosen.name.text))
            continue
        new = {i: _new_name(tree, declared.arguments[i], scope) for i, tree in enumerate(chosen.arguments or ())}
        bound = {i: name for i, name in new.items() if name is not None}
        if bound and len(forbid.actions) > 1:
            what, wanted = "a name for an argument", "a number or a word where `forbid` lists several actions"
            first = next(iter(bound.values()))
            raise scope.problems.fail(errors.WrongSort(first.span, name=first.text, what=what, wanted=wanted))
        numbers += _numbers(chosen, declared, bound, scope)
        if bound:
            action, names = declared.name, tuple(bound[i].text if i in bound else "" for i in range(len(declared.arguments)))
        for i, name in bound.items():
            check_free(name, inner, chosen=True)
            inner = inner.bind_named(name, _variable(name.text, declared.arguments[i]))
            if declared.arguments[i].type.kind == "word":
                named[name.text] = (name, declared.arguments[i])
    test = inner.condition(forbid.condition)
    _check_reads(test, forbid, scope)
    read = {variable.name for variable in free_variables(test)}
    for word, (written, argument) in named.items():
        if word not in read:  # a word that is misspelt looks like a new name
            raise not_a_word(written.span, word, action, argument.type.words, scope)
    numbers = numbers or list(range(len(scope.static.actions)))
    return ir.Forbid(actions=tuple(numbers), condition=test, action=action, names=names, origin=forbid.span)


def _declared(chosen: ast.Chosen, scope: Scope) -> ir.ActionWithArguments | None:
    name = chosen.name.text
    if name == "stay":
        what, wanted = "what forbidden actions become", "an action that can be forbidden"
        raise scope.problems.fail(errors.WrongSort(chosen.name.span, name=name, what=what, wanted=wanted))
    return declared_action(chosen, name, scope)


def _new_name(tree: ast.Expr, argument: ir.ActionArgument, scope: Scope) -> ast.Name | None:
    """Returns what stands in the place of an argument, if it is a name for it: one that means nothing else."""
    if not isinstance(tree, ast.Path) or tree.steps or tree.name.text in argument.type.words:
        return None
    return None if tree.name.text in scope.static.names() | set(scope.variables) else tree.name


def _variable(name: str, argument: ir.ActionArgument) -> ir.Expr:
    return ir.Member(name=name, sort=ir.Sort("agent")) if argument.type.kind == "agent" else ir.Local(type=argument.type, name=name)


def _numbers(chosen: ast.Chosen, declared: ir.ActionWithArguments, bound: dict[int, ast.Name], scope: Scope) -> list[int]:
    """Returns the numbers of the actions that have the arguments which are written as numbers or words."""
    wanted = [range(argument.count) for argument in declared.arguments]
    for i, tree in enumerate(chosen.arguments or ()):
        if i not in bound:
            at = fixed_argument(tree, declared.arguments[i], chosen, scope)
            wanted[i] = range(at, at + 1)
    everything = product(*(range(argument.count) for argument in declared.arguments))
    chosen_ones = set(product(*wanted))
    return [number for number, values in zip(declared.numbers, everything, strict=True) if values in chosen_ones]


def _check_reads(test: ir.Expr, forbid: ast.Forbid, scope: Scope) -> None:
    for node in ir.walk(test):
        where = isinstance(node, ir.Distance) or (isinstance(node, ir.Attribute) and node.name in ("row", "col"))
        if ir.is_expression(node) and (
            where
            or isinstance(node, ir.Count | ir.Sum | ir.Extreme | ir.StandsOn | ir.Chose | ir.ChoseWith)
            or (isinstance(node, ir.FieldRead) and node.held_by.what == "agent" and not isinstance(node.owner, ir.Member))
        ):
            raise scope.problems.fail(errors.ForbidReads(node.origin or forbid.span, what=f"`{text(node)}`"))
