"""Random scripted policies and scenarios; and whether compiled policies choose what interpreted ones do where play leads to."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.lower import NotSupported
from sjdsl.interpreter.state import World as State
from sjdsl.policies.compiled import Chooser
from sjdsl.policies.interpreted import choose
from sjdsl.runtime.env import Environment
from tests.fuzz.acting import taken
from tests.fuzz.conditions import condition
from tests.fuzz.declared import Lines, World
from tests.fuzz.members import domain, shape_for
from tests.fuzz.reading import Scope, Variable
from tests.fuzz.statements import braces

NAMES = ("greedy", "shy", "helpful")


def policies(w: World) -> list[Lines]:
    """Declares some policies."""
    made = []
    for name in w.random.sample(NAMES, w.random.choice((0, 0, 1, 2))):
        made.append(
            braces(f"policy {name}{_title(w)}", [_rule(w) for _ in range(w.random.randint(1, 3))])
        )
        w.policies.append(name)
    return made


def scenarios(w: World) -> list[Lines]:
    """Declares scenarios that the policies play in."""
    made = []
    for number in range(w.random.choice((0, 0, 1, 2))):
        focal = w.random.randint(1, w.agents)
        who = w.random.choice(("random", "stay", *w.policies))
        rest = (
            [f"slots {w.agents - focal} policy {who}"] if focal < w.agents or w.is_now(0.1) else []
        )
        made.append(
            braces(f"scenario line_up_{number}{_title(w)}", [f"slots {focal} focal", *rest])
        )
    return made


def _title(w: World) -> str:
    return ' "as it likes"' if w.is_now(0.4) else ""


def _rule(w: World) -> str:
    sort = w.random.choice(("act", "go", "go", "aim"))
    guard, scope = _guard(w, Scope(w, "policy").having(Variable("agent")), needed=sort == "act")
    action = (taken(scope) if w.is_now(0.4) else "") or w.random.choice(w.actions)
    match sort:
        case "act":
            return f"{guard}choose {action}"
        case "go":
            return f"{guard}seek {_sought(scope)}"
        case _:
            shape, _ = shape_for(scope, agent=True)
            return f"{guard}aim {shape} at {_sought(scope)} choose {action}"


def _guard(w: World, scope: Scope, needed: bool) -> tuple[str, Scope]:
    """Returns `when C `, `when on KIND `, or nothing where no guard is needed, and the scope behind it."""
    if not needed and w.is_now(0.6):
        return "", scope
    if w.is_now(0.6):
        return f"when {condition(scope, 2)} ", scope
    kind = w.random.choice([*w.kinds, *w.groups])
    name = w.variable() if w.is_now(0.5) else kind
    bind = "" if name == kind else f" as {name}"
    scope = scope.having(Variable(name, w.kinds_of(kind)))
    where = f"where {condition(scope, 1)} " if w.is_now(0.6) else ""
    return f"when on {kind}{bind} {where}", scope


def _sought(scope: Scope) -> str:
    text, avoided = (domain(scope, 1)[0] for _ in range(2))
    return f"{text} avoiding {avoided}" if scope.world.is_now(0.4) else text


class Compiled(SimpleNamespace):
    """A state of a compiled module, by the names of its fields."""

    def replace(self, **changed: Any) -> "Compiled":
        return Compiled(**{**vars(self), **changed})


def different_choice(
    game: ir.Game, env: Environment, states: Sequence[Any], worlds: Sequence[State], seed: int
) -> str:
    """Returns the first choice in which compiled and interpreted policies differ, empty if there is none.

    Args:
      states: of the compiled module, on NumPy or JAX; worlds: the same of the interpreter.
    """
    params = Compiled(**{name: jnp.asarray(value) for name, value in vars(env.params).items()})
    on_jax: Any = SimpleNamespace(
        game=game, module=env.module, num_agents=env.num_agents, cells=env.cells, params=params
    )
    choosers: list[tuple[ir.ScriptedPolicy, Chooser]] = []
    for policy in game.policies:
        try:
            choosers.append((policy, Chooser(on_jax, policy)))
        except NotSupported:
            continue  # a stated limit
    if not choosers or not states:
        return ""
    bits = np.random.default_rng(seed).integers(
        0, 2**32, (len(states), game.agents.number, 2), np.uint32
    )
    stacked = {
        name: np.stack([np.asarray(vars(state)[name]) for state in states])
        for name in vars(states[0])
    }
    chosen = jax.jit(
        jax.vmap(lambda state, own: [chooser(Compiled(**state), own) for _, chooser in choosers])
    )(stacked, bits)
    for (policy, _), actions in zip(choosers, chosen, strict=True):
        for number, world in enumerate(worlds):
            wanted = [
                choose(policy, game, world, agent, tuple(map(int, bits[number, agent])))
                for agent in range(game.agents.number)
            ]
            if actions[number].tolist() != wanted:
                return f"policy {policy.name}: {actions[number].tolist()} instead of {wanted} in {world}"
    return ""
