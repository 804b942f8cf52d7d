"""Elaborates scripted policies and scenarios: the rules by which an agent plays, and the line-ups of focal agents among others.

policy greedy { seek tree where tree.fruit is ripe }   ->   ScriptedPolicy(name="greedy", rules=(Go(...),))
"""

from collections.abc import Sequence
from typing import assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.actions import arguments_given, check_exists, declared_action
from sjdsl.compiler.elaborate.domains import domain
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.elaborate.statements import check_possible, why_impossible
from sjdsl.compiler.ir.implications import conjuncts

WITHOUT_RULES = ("random", "stay")  # policies that every game has
OF_EXPECT = ("never", "seek")


def policies(game: Composition, static: Static, problems: Problems) -> tuple[ir.ScriptedPolicy, ...]:
    """Returns the policies of a game, their rules typed."""
    scope = Scope(static, problems, part="policy").bind("agent", ir.Member(name="agent", sort=ir.Sort("agent")))
    found = []
    for policy in game.policies.values():
        with problems.survive():
            if policy.name.text in (*WITHOUT_RULES, *OF_EXPECT):
                raise problems.fail(errors.NameTaken(policy.name.span, name=policy.name.text, what="a policy of the language"))
            rules = _rules(policy.rules, scope)
            title = "" if policy.title is None else policy.title.text
            found.append(ir.ScriptedPolicy(name=policy.name.text, title=title, rules=rules, origin=policy.name.span))
    return tuple(found)


def _rules(written: Sequence[ast.Act | ast.Go | ast.Aim], scope: Scope) -> tuple[ir.PolicyRule, ...]:
    """Each rule is read where no `when` above it holds; one that is never reached is warned of."""
    found: list[ir.PolicyRule] = []
    ended = ""
    for rule in written:
        if ended:
            scope.problems.add(errors.NeverHappens(rule.span, problem=f"the rule above always applies ({ended})"))
            ended = ""
        found.append(_rule(rule, scope))
        if isinstance(found[-1], ir.Act):
            condition = found[-1].condition
            check_possible(condition, scope)
            ended = _why_certain(condition, scope)
            scope = scope.knowing([ir.Not(value=condition)])
    return tuple(found)


def _why_certain(condition: ir.Expr, scope: Scope) -> str:
    """Returns why a condition always holds, empty if it may not."""
    return next((why for part in conjuncts(ir.Not(value=condition)) if (why := why_impossible(part, scope))), "")


def _rule(rule: ast.Act | ast.Go | ast.Aim, scope: Scope) -> ir.PolicyRule:
    match rule:
        case ast.Act():
            test = scope.condition(rule.condition)
            action, chosen, given = _taken(rule.action, scope.knowing([test]))
            return ir.Act(condition=test, action=action, chosen=chosen, given=given, origin=rule.span)
        case ast.Go():
            return ir.Go(domain=domain(rule.domain, scope)[0], avoided=_avoided(rule, scope), origin=rule.span)
        case ast.Aim():
            shape = shapes.used(rule.shape, scope).name
            sought, avoided = domain(rule.domain, scope)[0], _avoided(rule, scope)
            action, chosen, given = _taken(rule.action, scope)
            return ir.Aim(shape=shape, domain=sought, avoided=avoided, action=action, chosen=chosen, given=given, origin=rule.span)
        case _:
            assert_never(rule)


def _taken(action: ast.Chosen, scope: Scope) -> tuple[int, str, tuple[ir.Given, ...]]:
    """Returns the number of an action; of one with arguments the first number, its name, and its arguments."""
    name = action.name.text
    declared = declared_action(action, name, scope)
    if declared is None:
        return scope.static.actions.index(name), "", ()
    if action.arguments is None:
        wanted = f"{len(declared.arguments)} argument{'s' * (len(declared.arguments) != 1)}"
        raise scope.problems.fail(errors.WrongArguments(action.span, name=name, wanted=wanted, given=0))
    asked = arguments_given(action, declared, scope)
    check_exists(asked, declared, scope)
    return declared.first, name, asked


def _avoided(rule: ast.Go | ast.Aim, scope: Scope) -> ir.Domain | None:
    return None if rule.avoided is None else domain(rule.avoided, scope)[0]


def scenarios(game: Composition, static: Static, problems: Problems, own_number: bool) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios of a game.

    Args:
      own_number: whether the number of agents is the file's. If a caller has chosen another, a scenario that it does not fill is kept:
        who plays it is told.
    """
    scope, found = Scope(static, problems), []
    for scenario in game.scenarios.values():
        with problems.survive():
            slots = tuple(_slots(part, game, scope) for part in scenario.slots)
            name, total = scenario.name.text, sum(part.number for part in slots)
            if own_number and (total != static.num_agents or any(part.number < 0 for part in slots)):
                raise problems.fail(errors.SlotsUnfilled(scenario.name.span, name=name, given=total, agents=static.num_agents))
            if not any(not part.policy and (part.number or not own_number) for part in slots):
                raise problems.fail(errors.NoFocalSlot(scenario.name.span, name=name))
            title = "" if scenario.title is None else scenario.title.text
            found.append(ir.Scenario(name=name, title=title, slots=slots, origin=scenario.name.span))
    return tuple(found)


def _slots(part: ast.Slots, game: Composition, scope: Scope) -> ir.Slots:
    number = scope.fixed(part.number, "a number of slots")
    if number != int(number):
        raise scope.problems.fail(errors.WrongType(part.number.span, wanted="a whole number of slots", given=f"{number:g}"))
    number = int(number)
    if part.policy is None:
        return ir.Slots(number=number, origin=part.span)
    known = (*game.policies, *WITHOUT_RULES)
    if part.policy.text not in known:
        raise scope.problems.unknown(part.policy, known, "the policies")
    if part.policy.text in game.policies:
        scope.static.refer(part.policy, Symbol("policy", part.policy.text))
    return ir.Slots(number=number, policy=part.policy.text, origin=part.span)
