"""Elaborates scripted policies and scenarios: the rules by which an agent plays, and the line-ups of focal agents among others.

policy greedy { seek tree where tree.fruit is ripe }   ->   ScriptedPolicy(name="greedy", rules=(Go(...),))
"""

from collections.abc import Sequence

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.actions import arguments_given, check_exists, declared_action
from sjdsl.compiler.elaborate.domains import domain
from sjdsl.compiler.elaborate.lookup import check_arguments
from sjdsl.compiler.elaborate.possible import check_possible, why_impossible
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.implications import conjuncts

WITHOUT_RULES = ("random", "stay")  # policies that every game has
OF_EXPECT = ("never", "seek")


def policies(game: Composition, scope: Scope) -> tuple[ir.ScriptedPolicy, ...]:
    """Returns the policies of a game, their rules typed. `scope`: in which `agent` is the one that plays by them."""

    def scripted(policy: ast.ScriptedPolicy) -> ir.ScriptedPolicy:
        name = policy.name
        if name.text in (*WITHOUT_RULES, *OF_EXPECT):
            raise scope.fail(
                errors.NameTaken(name.span, name=name.text, taken_by="a policy of the language")
            )
        title = "" if policy.title is None else policy.title.text
        return ir.ScriptedPolicy(
            name=name.text, title=title, rules=_rules(policy.rules, scope), origin=name.span
        )

    return tuple(scope.problems.each(game.policies.values(), scripted))


def _rules(
    written: Sequence[ast.Act | ast.Go | ast.Aim], scope: Scope
) -> tuple[ir.PolicyRule, ...]:
    """Each rule is read where no `when` above it holds; one that is never reached is warned of."""
    found: list[ir.PolicyRule] = []
    certain = ""  # why the rule above always applies, empty if it may not
    for rule in written:
        if certain:
            scope.problems.add(
                errors.NeverHappens(rule.span, problem=f"the rule above always applies ({certain})")
            )
            certain = ""
        made = _rule(rule, scope)
        found.append(made)
        if isinstance(made, ir.Act):
            check_possible(made.condition, scope)
            otherwise = ir.Not(value=made.condition)
            certain = next(
                (why for part in conjuncts(otherwise) if (why := why_impossible(part, scope))), ""
            )
            scope = scope.knowing([otherwise])
    return tuple(found)


def _rule(rule: ast.Act | ast.Go | ast.Aim, scope: Scope) -> ir.PolicyRule:
    if isinstance(rule, ast.Act):
        test = scope.condition(rule.condition)
        action, chosen, given = _taken(rule.action, scope.knowing([test]))
        return ir.Act(condition=test, action=action, chosen=chosen, given=given, origin=rule.span)
    shape = "" if isinstance(rule, ast.Go) else shapes.used(rule.shape, scope).name
    sought = domain(rule.domain, scope)[0]
    avoided = None if rule.avoided is None else domain(rule.avoided, scope)[0]
    if isinstance(rule, ast.Go):
        return ir.Go(domain=sought, avoided=avoided, origin=rule.span)
    action, chosen, given = _taken(rule.action, scope)
    return ir.Aim(
        shape=shape,
        domain=sought,
        avoided=avoided,
        action=action,
        chosen=chosen,
        given=given,
        origin=rule.span,
    )


def _taken(action: ast.Chosen, scope: Scope) -> tuple[int, str, tuple[ir.Given, ...]]:
    """Returns the number of an action; of one with arguments the first number, its name, and its arguments."""
    name = action.name.text
    declared = declared_action(action, name, scope)
    if declared is None:
        return scope.static.actions.index(name), "", ()
    check_arguments(name, action.span, len(action.arguments or ()), len(declared.arguments), scope)
    asked = arguments_given(action, declared, scope)
    check_exists(asked, declared, scope)
    return declared.first, name, asked


def scenarios(game: Composition, scope: Scope) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios of a game; where a caller has chosen the number of agents, also those that it doesn't fill."""
    static, number_from_file = scope.static, scope.static.number_from_file

    def one(scenario: ast.Scenario) -> ir.Scenario:
        slots = tuple(_slots(part, game, scope) for part in scenario.slots)
        name, span, total = (
            scenario.name.text,
            scenario.name.span,
            sum(part.number for part in slots),
        )
        if number_from_file and (
            total != static.num_agents or any(part.number < 0 for part in slots)
        ):
            raise scope.fail(
                errors.SlotsUnfilled(span, name=name, slots=total, agents=static.num_agents)
            )
        if not any(not part.policy and (part.number or not number_from_file) for part in slots):
            raise scope.fail(errors.NoFocalSlot(span, name=name))
        title = "" if scenario.title is None else scenario.title.text
        return ir.Scenario(name=name, title=title, slots=slots, origin=span)

    return tuple(scope.problems.each(game.scenarios.values(), one))


def _slots(part: ast.Slots, game: Composition, scope: Scope) -> ir.Slots:
    number = scope.fixed(part.number, "a number of slots")
    if number != int(number):
        raise scope.expected(part.number.span, "a whole number of slots", f"{number:g}")
    number = int(number)
    if part.policy is None:
        return ir.Slots(number=number, origin=part.span)
    known = (*game.policies, *WITHOUT_RULES)
    if part.policy.text not in known:
        raise scope.problems.unknown(part.policy, known, "the policies")
    if part.policy.text in game.policies:
        scope.static.refer(part.policy, Symbol("policy", part.policy.text))
    return ir.Slots(number=number, policy=part.policy.text, origin=part.span)
