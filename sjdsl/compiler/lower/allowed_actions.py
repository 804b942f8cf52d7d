"""Lowers `forbid`: the function that says which actions are open to each agent."""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named
from sjdsl.compiler.lower.axes import Axis, Value, aligned, iota
from sjdsl.compiler.lower.chosen import argument_value
from sjdsl.compiler.lower.scope import AgentVar, IterationScope
from sjdsl.compiler.lower.writer import Module, Writer
from sjdsl.compiler.program import Function
from sjdsl.compiler.program import expressions as array

READING = (("state", "State"), ("params", "Params"))
NUM_ACTIONS = array.call("len", array.Name("ACTIONS"))


def allowed_actions(module: Module) -> Function:
    """Returns the function of the actions that are open; what is forbidden or unknown becomes `stay` elsewhere."""
    w = Writer(module)
    agents = module.game.agents
    axes = (w.axis("agent", module.agents), w.axis("action", len(agents.actions)))
    everything = array.call(
        "jnp.ones", array.Sequence((module.agents, NUM_ACTIONS)), array.Name("bool")
    )
    allowed: array.Expression = everything
    for forbid in agents.forbids:
        w.origin = forbid.origin
        test = w.keep("forbidden", w.value(forbid.condition, _scope(forbid, axes, w)))
        closes = [a in forbid.actions and name != "stay" for a, name in enumerate(agents.actions)]
        name = module.constant(
            "forbids", array.constant(closes), "actions a `forbid` is about", "bool"
        )
        closed = w.bind(
            "closed", array.Binary("&", aligned(test, axes), array.Index(name, (array.NEW_AXIS,)))
        )
        first = allowed == everything and axes[0] in test.axes
        allowed = (
            array.Unary("~", closed)
            if first
            else array.Binary("&", allowed, array.Unary("~", closed))
        )
    w.origin = None
    w.give_back(allowed)
    doc = "Returns which actions each agent may take: `[N, A]` bool."
    return Function("allowed_actions", READING, "Array", doc, array.live(w.body))


def _scope(forbid: ir.Forbid, axes: tuple[Axis, Axis], w: Writer) -> IterationScope:
    """Returns the scope of a condition: the agent, and along the actions the arguments that the `forbid` names."""
    scope = IterationScope(axes=axes, variables={"agent": AgentVar(iota(axes[0]), axes[0])})
    if not forbid.names:
        return scope
    action = action_named(w.module.game, forbid.action)
    rest = len(action.numbers)
    for name, argument in zip(forbid.names, action.arguments, strict=True):
        rest //= argument.count
        if not name:
            continue
        at = [
            (a - action.first) // rest % argument.count if a in action.numbers else 0
            for a in range(axes[1].size)
        ]
        comment = f"the argument `{name}` of each action that is {action.name}(..), 0 of others"
        table = w.module.constant(f"{action.name}_{name}", array.constant(at), comment, "i32")
        value = argument_value(argument, Value(table, "i32", (axes[1],)))
        if argument.type.kind == "agent":
            scope = scope.binding(**{name: AgentVar(value)})
        else:
            scope = replace(scope, locals={**scope.locals, name: value})
    return scope
