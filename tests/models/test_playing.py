"""A language policy plays a whole episode on the interpreter, told and asked as in use."""

from sjdsl.compiler.lower import token_planes
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.models import FakeProvider, LanguagePolicy, Message
from sjdsl.told import Past, Window, message, told
from tests.told.corpus import game


def test_an_episode_with_a_fake_model() -> None:
    g = game("two_trees")
    window = Window(g, token_planes(g))
    policy = LanguagePolicy(FakeProvider())
    world = reset(g, {}, Threefry(3, 0))
    past: list[Past] = []
    for number in range(1, 51):
        mask = action_mask(g, world)[0]
        allowed = tuple(name for name, may in zip(g.agents.actions, mask, strict=True) if may)
        text = message(window, observe(g, world)[0], mask, past)
        reply = policy.decide(0, Message(told(g), text, g.agents.actions, allowed))
        assert reply.action in allowed
        assert reply.problem == ""
        action = g.agents.actions.index(reply.action)
        world, outcome = step(g, world, [action], {}, Threefry(3, number))
        past.append(Past(reply.action, float(outcome.reward[0])))
        if outcome.truncated or outcome.terminated:
            break
    assert world.fields["trial"] == 4
    assert len(past) > 10
