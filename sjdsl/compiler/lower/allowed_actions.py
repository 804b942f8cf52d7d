"""Lowers `forbid`: the function that says which actions are open to each agent."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named
from sjdsl.compiler.lower.axes import Axis, Value, aligned
from sjdsl.compiler.lower.chosen import argument_value
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, scope_of_agents
from sjdsl.compiler.lower.writer import Module, Writer
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import Expression, Name, call, live

READING = (("state", "State"), ("params", "Params"))
NUM_ACTIONS = call("len", Name("ACTIONS"))


def allowed_actions(module: Module) -> Function:
    """Returns the function of the actions that each agent may take."""
    w = Writer(module)
    agents = module.game.agents
    axes = (w.axis("agent", module.agents), w.axis("action", len(agents.actions)))
    everything = call("jnp.ones", (module.agents, NUM_ACTIONS), Name("bool"))
    allowed: Expression = everything
    for forbid in agents.forbids:
        w.origin = forbid.origin
        test = w.keep("forbidden", w.value(forbid.condition, _scope(forbid, axes, w)))
        closes = [a in forbid.actions and name != "stay" for a, name in enumerate(agents.actions)]
        comment = "actions a `forbid` is about"
        table = module.constant("forbids", closes, comment, "bool")
        closed = w.bind("closed", aligned(test, axes) & table[None])
        if allowed == everything and axes[0] in test.axes:
            allowed = ~closed
        else:
            allowed = allowed & ~closed
    w.origin = None
    w.give_back(allowed)
    doc = "Returns which actions each agent may take: `[N, A]` bool."
    return Function("allowed_actions", READING, "Array", doc, live(w.body))


def _scope(forbid: ir.Forbid, axes: tuple[Axis, Axis], w: Writer) -> IterationScope:
    """Returns the scope of a condition: the agent, and the arguments that the `forbid` names.

    The arguments are those of each action along the axis of the actions.
    """
    _, action_axis = axes
    scope = scope_of_agents(axes)
    if not forbid.names:
        return scope
    action = action_named(w.game, forbid.action)
    # The numbers of an action count its arguments up in mixed radix, the last argument fastest;
    # `rest` is the number of combinations of the arguments after this one.
    rest = len(action.numbers)
    for name, argument in zip(forbid.names, action.arguments, strict=True):
        rest //= argument.count
        if not name:
            continue
        places = [0] * action_axis.size
        for number in action.numbers:
            places[number] = (number - action.first) // rest % argument.count
        comment = f"the argument `{name}` of each action that is {action.name}(..), 0 of others"
        table = w.module.constant(f"{action.name}_{name}", places, comment, "i32")
        value = argument_value(argument, Value(table, "i32", (action_axis,)))
        if argument.type.kind == "agent":
            scope = scope.binding(name, AgentVar(value))
        else:
            scope = scope.letting(name, value)
    return scope
