"""Elaborates scripted policies, by whose rules an agent plays, and scenarios.

policy greedy { seek tree where tree.fruit is ripe }   ->   ScriptedPolicy("greedy", (Go(...),))
"""

from collections.abc import Sequence
from typing import Any

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.actions import arguments_given, check_exists, declared_action
from sjdsl.compiler.elaborate.domains import domain, new_member, with_member
from sjdsl.compiler.elaborate.lookup import check_arguments, kinds_named
from sjdsl.compiler.elaborate.possible import check_possible, why_impossible
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.implications import conjuncts

WITHOUT_RULES = ("random", "stay")  # policies that every game has
OF_EXPECT = ("never", "seek")


def policies(game: Composition, scope: Scope) -> tuple[ir.ScriptedPolicy, ...]:
    """Returns the policies of a game, their rules typed.

    scope: one in which `agent` is the one that plays by them.
    """

    def scripted(policy: ast.ScriptedPolicy) -> ir.ScriptedPolicy:
        """Returns a typed policy."""
        name = policy.name
        if name.text in (*WITHOUT_RULES, *OF_EXPECT):
            raise scope.fail(
                errors.NameTaken(name.span, name=name.text, taken_by="a policy of the language")
            )
        title = "" if policy.title is None else policy.title.text
        rules = _rules(policy.rules, scope)
        return ir.ScriptedPolicy(name=name.text, title=title, rules=rules, origin=name.span)

    return tuple(scope.problems.each(game.policies.values(), scripted))


def _rules(
    written: Sequence[ast.Act | ast.Go | ast.Aim], scope: Scope
) -> tuple[ir.PolicyRule, ...]:
    """Returns the rules, each read where no `when` above it holds; warns of unreachable ones."""
    rules: list[ir.PolicyRule] = []
    always_applies = ""  # why the rule above always applies, empty if it may not
    for tree in written:
        if always_applies:
            problem = f"the rule above always applies ({always_applies})"
            scope.problems.add(errors.NeverHappens(tree.span, problem=problem))
            always_applies = ""
        rule = _rule(tree, scope)
        rules.append(rule)
        if isinstance(rule, ir.Act) and rule.on is None:
            otherwise = ir.Not(value=rule.condition)
            reasons = (why_impossible(part, scope) for part in conjuncts(otherwise))
            always_applies = next(filter(None, reasons), "")
            scope = scope.knowing([otherwise])
    return tuple(rules)


def _rule(rule: ast.Act | ast.Go | ast.Aim, scope: Scope) -> ir.PolicyRule:
    """Returns a typed rule of a scripted policy."""
    on, test, scope = _guarded(rule.guard, scope)
    if isinstance(rule, ast.Act):
        assert test is not None, rule
        return ir.Act(on=on, condition=test, **_action(rule.action, scope), origin=rule.span)
    goal, _ = domain(rule.domain, scope)
    avoided = None
    if rule.avoided is not None:
        avoided, _ = domain(rule.avoided, scope)
    if isinstance(rule, ast.Go):
        return ir.Go(on=on, condition=test, domain=goal, avoided=avoided, origin=rule.span)
    action = _action(rule.action, scope)
    return ir.Aim(
        on=on,
        condition=test,
        shape=shapes.used(rule.shape, scope).name,
        domain=goal,
        avoided=avoided,
        **action,
        origin=rule.span,
    )


def _guarded(
    guard: ast.Guard | None, scope: Scope
) -> tuple[ir.Member | None, ir.Expr | None, Scope]:
    """Returns the cell that a guard binds, its condition, and the scope of the rest of the rule."""
    if guard is None:
        return None, None, scope
    on = None
    test: ir.Expr | None = None
    if guard.on is not None:
        agent = scope.variables["agent"]
        assert isinstance(agent, ir.Member)
        on = new_member(guard.on, ir.EntityType("cell", kinds_named(guard.on.kind, scope)), scope)
        scope = with_member(guard.on, on, scope)
        test = ir.StandsOn(agent=agent, kinds=on.kinds, origin=guard.on.span)
        scope = scope.knowing([test])
    if guard.condition is not None:
        test = scope.condition(guard.condition)
        check_possible(test, scope)
        scope = scope.knowing([test])
    return on, test, scope


def _action(action: ast.Chosen, scope: Scope) -> dict[str, Any]:
    """Returns the fields of a rule that say which action is taken.

    One with arguments has several numbers, of which `action` is the first.
    """
    name = action.name.text
    declared = declared_action(action, name, scope)
    if declared is None:
        return {"action": scope.static.actions.index(name)}
    number = len(action.arguments or ())
    check_arguments(name, action.span, number, len(declared.arguments), scope)
    given = arguments_given(action, declared, scope)
    check_exists(given, declared, scope)
    return {"action": declared.first, "chosen": name, "given": given}


def scenarios(game: Composition, scope: Scope) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios of a game.

    Where a caller has chosen the number of agents, slots needn't add up to it.
    """
    static = scope.static
    has_written_number = static.number_from_file

    def typed(scenario: ast.Scenario) -> ir.Scenario:
        """Returns a typed scenario, whose slots are as many as agents."""
        slots = tuple(_slots(part, game, scope) for part in scenario.slots)
        name = scenario.name.text
        span = scenario.name.span
        total = sum(part.number for part in slots)
        is_filled = total == static.num_agents and all(part.number >= 0 for part in slots)
        if has_written_number and not is_filled:
            raise scope.fail(
                errors.SlotsUnfilled(span, name=name, slots=total, agents=static.num_agents)
            )
        focal = [part for part in slots if not part.policy]
        has_focal = any(part.number for part in focal) if has_written_number else bool(focal)
        if not has_focal:
            raise scope.fail(errors.NoFocalSlot(span, name=name))
        title = "" if scenario.title is None else scenario.title.text
        return ir.Scenario(name=name, title=title, slots=slots, origin=span)

    return tuple(scope.problems.each(game.scenarios.values(), typed))


def _slots(part: ast.Slots, game: Composition, scope: Scope) -> ir.Slots:
    """Returns the typed slots of a scenario: how many, and which policy plays there."""
    value = scope.fixed(part.number, "a number of slots")
    number = int(value)
    if value != number:
        raise scope.expected(part.number.span, "a whole number of slots", f"{value:g}")
    if part.policy is None:
        return ir.Slots(number=number, origin=part.span)
    name = part.policy.text
    known = (*game.policies, *WITHOUT_RULES)
    if name not in known:
        raise scope.problems.unknown(part.policy, known, "the policies")
    if name in game.policies:
        scope.static.refer(part.policy, Symbol("policy", name))
    return ir.Slots(number=number, policy=name, origin=part.span)
