"""Elaborates `metrics` and `checks`: events, measures, and conditions that must hold."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.elaborate.actions import action_numbers
from sjdsl.compiler.elaborate.declaration_labels import numbers_read
from sjdsl.compiler.elaborate.defines import use as use_define
from sjdsl.compiler.elaborate.domains import domain
from sjdsl.compiler.elaborate.map_counts import of_the_map
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.types import describe, is_number

REQUIRES = "use numbers, `size`s, `param`s and `count(KIND where …)` of the map as it is drawn; `always` speaks of every state of play"


def requires(game: Composition, scope: Scope) -> tuple[ir.Expr, ...]:
    """Returns the conditions of all `require`s, about numbers and the map only; proofs elsewhere rely on them."""
    found = []
    for check in _written(game):
        if isinstance(check, ast.Require):
            with scope.problems.survive(), scope.static.requiring():
                test = of_the_map(scope.condition(check.condition), scope.static)
                for node in ir.walk(test):
                    if isinstance(node, ir.FieldRead | ir.Count | ir.Sum | ir.Extreme | ir.EventTotal | ir.Step | ir.Member):
                        raise scope.problems.fail(errors.NotFixed(node.origin or check.span, what="what a `require` reads", help=REQUIRES))
                found.append(test)
    return tuple(found)


def _written(game: Composition) -> Iterable[ast.Check]:
    return chain.from_iterable(game.checks.values())


def check_requires(game: Composition, scope: Scope) -> None:
    """Reports every `require` that the file's own numbers break."""
    values = {p.name: p.value for p in scope.static.params.values()}
    for test in scope.static.requires:
        if not holds(test, values):
            shown = ", ".join(f"{n} is {values[n]}" for n in sorted(_params(test)) if not isinstance(values[n], tuple))
            problem = text(test) + (f" ({shown})" if shown else "")
            scope.problems.add(errors.RequireFalse(test.origin or game.span, labels=numbers_read(test, game), problem=problem))


def _params(test: ir.Expr) -> set[str]:
    return {n.name for n in ir.walk(test) if isinstance(n, ir.ParamRef)}


def events(phases: Iterable[ir.Node], scope: Scope) -> tuple[ir.Event, ...]:
    """Returns the declared events; each is counted for agents or for the game, not both."""
    tallies = [n for phase in phases for n in ir.walk(phase) if isinstance(n, ir.Tally)]
    found = []
    for event in scope.static.events.values():
        mine = [t for t in tallies if t.event == event.name.text]
        per_agent = {t.receiver is not None for t in mine} or {True}
        if len(per_agent) > 1:
            raise scope.problems.fail(
                errors.WrittenTwice(event.span, what=f"event `{event.name.text}` counted with and without `for`, so it")
            )
        by = scope.static.event_levels.get(event.name.text)
        found.append(ir.Event(name=event.name.text, by=by, per_agent=per_agent.pop(), origin=event.span))
    return tuple(found)


def measures(game: Composition, scope: Scope) -> tuple[ir.Measure, ...]:
    """Returns the `mean` and `final` metrics, numbers over the state."""
    found = []
    for metric in game.metrics.values():
        if isinstance(metric, ast.Measure):
            with scope.problems.survive():
                value = scope.expression(metric.value)
                if not is_number(value.type):
                    raise wrong_type(scope, metric.value, "a number", value.type)
                found.append(ir.Measure(name=metric.name.text, mean=metric.is_mean, value=value, origin=metric.span))
    return tuple(found)


def checks(game: Composition, scope: Scope) -> tuple[ir.Check, ...]:
    """Returns the checks of a game, their expressions typed."""
    found = []
    for check in _written(game):
        with scope.problems.survive():
            found.append(_check(check, game, scope))
    return tuple(found)


def _check(check: ast.Check, game: Composition, scope: Scope) -> ir.Check:
    match check:
        case ast.Require():
            with scope.static.requiring():
                test = of_the_map(scope.condition(check.condition), scope.static)
            return ir.Check(sort="require", values=(test,), origin=check.span)
        case ast.Always():
            return ir.Check(sort="always", values=(replace(scope, about_steps=True).condition(check.condition),), origin=check.span)
        case ast.Once():
            steps = replace(scope, about_steps=True)
            values = (steps.condition(check.trigger), steps.condition(check.condition))
            return ir.Check(sort="once", values=values, origin=check.span)
        case ast.Conserved():
            return ir.Check(sort="conserved", values=(_single(check.value, scope.expression(check.value), scope),), origin=check.span)
        case ast.Monotone():
            return _monotone(check, scope)
        case ast.Symmetric():
            known = ("agents", "mirror", *scope.static.movers)
            if check.what.text not in known:
                raise scope.problems.unknown(check.what, known, "the symmetries")
            if check.what.text in scope.static.movers:
                scope.static.refer(check.what, Symbol("name", check.what.text))
            return ir.Check(sort="symmetric", words=(check.what.text,), origin=check.span)
        case ast.Expect():
            return _expect(check, game, scope)


def _single(tree: ast.Expr, value: ir.Expr, scope: Scope) -> ir.Expr:
    if value.type.by or value.type.kind not in ("int", "real", "word", "condition"):
        raise wrong_type(scope, tree, "one value (a number, a word, a condition)", value.type)
    return value


def _monotone(check: ast.Monotone, scope: Scope) -> ir.Check:
    values = []
    for name in (check.value, check.argument):
        if name.text not in scope.static.defines:
            meant = near(name.text, scope.static.defines, "the defines")
            raise scope.problems.fail(errors.WrongSort(name.span, name=name.text, what="no define", wanted="a define", near=meant))
        values.append(use_define(name, (), scope))
        if not is_number(values[-1].type):
            raise scope.problems.fail(errors.WrongType(name.span, wanted="a number", given=describe(values[-1].type)))
    if check.direction.text not in ("falling", "rising"):
        raise scope.problems.unknown(check.direction, ("falling", "rising"), "the directions")
    words = (check.direction.text, check.value.text, check.argument.text)
    return ir.Check(sort="monotone", values=tuple(values), words=words, origin=check.span)


def _expect(check: ast.Expect, game: Composition, scope: Scope) -> ir.Check:
    test = scope.condition(check.condition)
    policies = tuple(_policy(p, game, scope) for p in check.policies)
    return ir.Check(sort="expect", values=(test,), policies=policies, episodes=check.episodes, origin=check.span)


def _policy(policy: ast.Policy, game: Composition, scope: Scope) -> ir.Policy:
    name = policy.name.text
    if policy.domain is not None:
        seeker = scope.bind("agent", ir.Member(name="agent", sort=ir.Sort("agent")))
        built, _ = domain(policy.domain, seeker)
        return ir.Policy(name="seek", domain=built, origin=policy.span)
    if name in game.policies and not policy.actions:
        scope.static.refer(policy.name, Symbol("policy", name))
        return ir.Policy(name="scripted", scripted=name, origin=policy.span)
    if name not in ("random", "never") or (name == "never") != bool(policy.actions):
        raise scope.problems.unknown(policy.name, ("random", "never(ACTION)", "seek KIND", *game.policies), "the policies")
    actions = tuple(number for action in policy.actions for number in action_numbers(ast.Chosen(action.span, action, None), scope))
    return ir.Policy(name=name, actions=actions, origin=policy.span)  # type: ignore[arg-type]
