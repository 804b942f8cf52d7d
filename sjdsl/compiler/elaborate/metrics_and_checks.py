"""Elaborates `metrics` and `checks`: events, measures, and conditions that must hold."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from typing import Any

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.elaborate.actions import action_numbers
from sjdsl.compiler.elaborate.declaration_labels import parameters_read
from sjdsl.compiler.elaborate.domains import domain, most_members
from sjdsl.compiler.elaborate.lookup import is_member, use_define
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.fold import UnknownValue
from sjdsl.compiler.ir.printer import domain_text
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.types import describe, integer, is_number
from sjdsl.compiler.ir.values import TOLERANCE, Evaluation, decided, holds

REQUIRES = (
    "use numbers, `size`s, `param`s and `count(KIND where …)` of the map as it is drawn; "
    "`always` covers every state of play"
)
CHANGING = ir.FieldRead | ir.Aggregate | ir.EventTotal | ir.Step | ir.Member


def declare_requires(game: Composition, scope: Scope) -> None:
    """Keeps what the `require`s say, which proofs elsewhere rely on.

    Reports those that read more than numbers and the map, and those that the numbers of the file
    break.
    """
    written = chain.from_iterable(game.checks.values())
    requires = [check for check in written if isinstance(check, ast.Require)]
    tests = scope.problems.each(requires, lambda check: _fixed_at_start(check, scope))
    scope.static.required_facts = scope.knowing(tests).facts
    for test in tests:
        _check_holds(test, scope)


def _fixed_at_start(check: ast.Require, scope: Scope) -> ir.Expr:
    """Returns the condition of a `require`; reports it if it reads what changes in an episode."""
    test = _required(check, scope)
    for node in ir.walk(test):
        if isinstance(node, CHANGING):
            span = node.origin or check.span
            quantity = "what a `require` reads"
            raise scope.fail(errors.NotFixed(span, quantity=quantity, help=REQUIRES))
    return test


def _required(check: ast.Require, scope: Scope) -> ir.Expr:
    with scope.static.requiring():
        return _with_map_counts(scope.condition(check.condition), scope.static)


def _with_map_counts(test: ir.Expr, static: Static) -> ir.Expr:
    """Returns a condition in which counts that the map decides are numbers; other counts stay.

    require count(gate) >= count(agent)   ->   7 >= 7

    Raises Poisoned for a game without a sound map.
    """

    def counted(node: ir.Node) -> ir.Node:
        """Returns a count that the map decides as its number, and other nodes as they are."""
        if not isinstance(node, ir.Count):
            return node
        members = _members_at_start(node.domain, static)
        if members is None:
            return node
        type_ = integer(members, members)
        number = ir.Number(type=type_, value=members, origin=node.origin)
        name = f"count({domain_text(node.domain)})"
        return ir.Named(type=type_, name=name, value=number, origin=node.origin)

    result: ir.Expr = rewrite(test, counted)
    return result


def _members_at_start(d: ir.Domain, static: Static) -> int | None:
    """Returns how many members a domain has at the start; None if the map doesn't decide that."""
    if d.on is not None or d.restriction is not None:
        return None
    if not is_member(d.var, "cell"):
        return most_members(d, static) if d.where is None else None
    if not static.rows:
        raise Poisoned
    members = 0
    for _, meaning in static.glyphs:
        if meaning.kind not in d.var.kinds:
            continue
        are_members = d.where is None or _holds_at_start(d.where, d.var, meaning, static)
        if are_members is None:
            return None
        if are_members:
            members += sum(row.count(meaning.glyph) for row in static.rows)
    return members


def _holds_at_start(
    test: ir.Expr, cell: ir.Member, meaning: ir.GlyphMeaning, static: Static
) -> bool | None:
    """Returns whether a condition holds for the cells of a character at the start.

    None: the fields of these cells don't decide it.
    """
    starts = {name: field.start for name, field in static.kinds[meaning.kind].items()}
    starts |= dict(meaning.starts)

    def start(e: ir.Expr) -> Any:
        """Returns the value that a field of the cell has at the start."""
        match e:
            case ir.FieldRead(owner=ir.Member(name=cell.name)) if not e.type.indexed_by:
                return starts[e.name]
            case _:
                raise UnknownValue

    return decided(test, Evaluation(start, tolerance=TOLERANCE))


def _check_holds(test: ir.Expr, scope: Scope) -> None:
    """Reports the condition of a `require` that the numbers of the file break."""
    values = {name: param.value for name, param in scope.static.params.items()}
    if holds(test, values):
        return
    parameters = {node.name for node in ir.walk(test) if isinstance(node, ir.ParamRef)}
    numbers = []
    for name in sorted(parameters):
        if not isinstance(values[name], tuple):
            numbers.append(f"{name} is {values[name]}")
    problem = text(test)
    if numbers:
        problem = f"{problem} ({', '.join(numbers)})"
    labels = parameters_read(scope.static, test)
    scope.problems.add(errors.RequireFalse(test.span, labels=labels, problem=problem))


def events(phases: Iterable[ir.Node], scope: Scope) -> tuple[ir.Event, ...]:
    """Returns the declared events; each is counted for agents or for the game, not both."""
    nodes = chain.from_iterable(map(ir.walk, phases))
    tallies = [node for node in nodes if isinstance(node, ir.Tally)]
    for_agents = {tally.event for tally in tallies if tally.receiver is not None}
    for_game = {tally.event for tally in tallies if tally.receiver is None}
    typed = []
    for name, event in scope.static.events.items():
        if name in for_agents and name in for_game:
            part = f"event `{name}` counted with and without `for`, so it"
            raise scope.fail(errors.WrittenTwice(event.span, part=part))
        by = scope.static.event_index_sets.get(name)
        per_agent = name not in for_game
        typed.append(ir.Event(name=name, by=by, per_agent=per_agent, origin=event.span))
    return tuple(typed)


def measures(game: Composition, scope: Scope) -> tuple[ir.Measure, ...]:
    """Returns the `mean` and `final` metrics, numbers over the state."""

    def measure(metric: ast.Measure) -> ir.Measure:
        value = scope.any_number(metric.value)
        name = metric.name.text
        return ir.Measure(name=name, mean=metric.is_mean, value=value, origin=metric.span)

    written = [metric for metric in game.metrics.values() if isinstance(metric, ast.Measure)]
    return tuple(scope.problems.each(written, measure))


def checks(game: Composition, scope: Scope) -> tuple[ir.Check, ...]:
    """Returns the checks of a game, their expressions typed."""
    written = chain.from_iterable(game.checks.values())
    return tuple(scope.problems.each(written, lambda check: _check(check, game, scope)))


def _check(check: ast.Check, game: Composition, scope: Scope) -> ir.Check:
    """Returns a typed check."""
    steps = replace(scope, about_steps=True)
    values: tuple[ir.Expr, ...] = ()
    words: tuple[str, ...] = ()
    policies: tuple[ir.Policy, ...] = ()
    episodes = 0
    match check:
        case ast.Require():
            values = (_required(check, scope),)
        case ast.Always():
            values = (steps.condition(check.condition),)
        case ast.Once():
            values = (steps.condition(check.trigger), steps.condition(check.condition))
        case ast.Conserved():
            value = scope.expression(check.value)
            if not value.type.is_single("int", "real", "word", "condition"):
                wanted = "one value (a number, a word, a condition)"
                raise wrong_type(scope, check.value, wanted, value.type)
            values = (value,)
        case ast.Monotone():
            values = _numbers_of_defines(check, scope)
            words = (check.direction.text, check.value.text, check.argument.text)
        case ast.Symmetric():
            name = check.what.text
            known = ("agents", *scope.static.movers)
            if name not in known:
                raise scope.problems.unknown(check.what, known, "the symmetries")
            if name in scope.static.movers:
                scope.static.refer(check.what, Symbol("name", name))
            words = (name,)
        case ast.Expect():
            values = (scope.condition(check.condition),)
            policies = tuple(_policy(policy, game, scope) for policy in check.policies)
            episodes = check.episodes
    return ir.Check(
        kind=type(check).__name__.lower(),  # type: ignore[arg-type]
        values=values,
        words=words,
        policies=policies,
        episodes=episodes,
        origin=check.span,
    )


def _numbers_of_defines(check: ast.Monotone, scope: Scope) -> tuple[ir.Expr, ...]:
    """Returns the two defines of which one falls or rises with the other."""
    values = []
    for name in (check.value, check.argument):
        if name.text not in scope.static.defines:
            meant = near(name.text, scope.static.defines, "the defines")
            raise scope.fail(
                errors.WrongSort(
                    name.span, name=name.text, actual="no define", wanted="a define", near=meant
                )
            )
        value = use_define(name, (), scope)
        if not is_number(value.type):
            raise scope.expected(name.span, "a number", describe(value.type))
        values.append(value)
    if check.direction.text not in ("falling", "rising"):
        raise scope.problems.unknown(check.direction, ("falling", "rising"), "the directions")
    return tuple(values)


def _policy(policy: ast.Policy, game: Composition, scope: Scope) -> ir.Policy:
    """Returns a policy of an `expect`."""
    name = policy.name.text
    if policy.domain is not None:
        goal, _ = domain(policy.domain, scope.bind_member("agent", AGENTS))
        return ir.Policy(name="seek", domain=goal, origin=policy.span)
    if name in game.policies and not policy.actions:
        scope.static.refer(policy.name, Symbol("policy", name))
        return ir.Policy(name="scripted", scripted=name, origin=policy.span)
    if name == "random" and not policy.actions:
        return ir.Policy(name="random", origin=policy.span)
    if name != "never" or not policy.actions:
        known = ("random", "never(ACTION)", "seek KIND", *game.policies)
        raise scope.problems.unknown(policy.name, known, "the policies")
    numbers: list[int] = []
    for action in policy.actions:
        numbers += action_numbers(ast.Chosen(action.span, action, None), scope)
    return ir.Policy(name="never", actions=tuple(numbers), origin=policy.span)
