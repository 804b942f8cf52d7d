"""A trained policy that drives agents: asked with what the interpreter's agents see, so that nothing of an episode is compiled."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import World
from sjdsl.interpreter.step import action_mask
from sjdsl.studio.episode import Episode
from sjdsl.studio.opened import Opened
from sjdsl.studio.runs import PolicyRefused, policy_file
from sjdsl.trace.choices import OTHERS
from sjdsl.trace.episode import Moment


class Trained:
    """A loaded policy.

    name: as it was asked for; game: the name of the one that it plays; note: what there is to say about it, empty if nothing.
    """

    def __init__(self, name: str, note: str, env: Any, policy: Any) -> None:
        """`env`: of the game that it is to play; policy: as `sjdsl.trainers.load_policy` gives it."""
        import jax

        from sjdsl.runtime.policy import with_memory

        self.name, self.note, self.game = name, note, str(env.game.name)
        self._env, self._policy, self._blank = env, with_memory(policy), None
        self._act: Callable[..., Any] = jax.jit(self._policy.act)
        self._remembers = bool(jax.tree.leaves(self._policy.start))
        self._known: list[tuple[Moment, Any]] = []  # the moments so far, each with what is remembered after it

    def fits(self, game: ir.Game) -> bool:
        """Whether it can act in a game as it is loaded. An edit that leaves bodies, actions and observations alone changes nothing for it."""
        own = self._env.game
        if game is own or game_hash(game) == game_hash(own):
            return True
        reads_rules = self._policy.reads_state or _roles(game) or _roles(own)
        return not reads_rules and _shape(game) == _shape(own)

    def actions(self, episode: Episode, seed: int) -> list[int]:
        """Returns an action for each agent in the moment that is shown. It remembers the moments before it that can be gone back to."""
        import jax

        key = jax.random.fold_in(jax.random.key(seed), OTHERS)
        memory = self._memory_before(episode, key) if self._remembers else self._policy.start
        after, actions = self._taken(memory, key, episode.game, episode.now.world)
        if self._remembers:
            self._known.append((episode.now, after))
        return [int(action) for action in actions]

    def _memory_before(self, episode: Episode, key: Any) -> Any:
        """Returns what is remembered before the moment that is shown: of what has been forgotten since, nothing."""
        past = episode.moments[: episode.at]
        same = next((i for i, (now, (then, _)) in enumerate(zip(past, self._known, strict=False)) if now is not then), None)
        del self._known[len(past) if same is None else same :]
        for moment in past[len(self._known) :]:
            before = self._known[-1][1] if self._known else self._policy.start
            self._known.append((moment, self._taken(before, key, episode.game, moment.world)[0]))
        return self._known[-1][1] if self._known else self._policy.start

    def _taken(self, memory: Any, key: Any, game: ir.Game, world: World) -> tuple[Any, Any]:
        import jax
        import numpy as np

        allowed = np.array(action_mask(game, world)) if self._policy.reads_allowed else None
        state = self._compiled(world) if self._policy.reads_state else None
        needed = self._policy.needs(allowed, state)
        return self._act(memory, jax.random.fold_in(key, world.step), observe(game, world), *needed)  # type: ignore[no-any-return]

    def _compiled(self, world: World) -> Any:
        """Returns a state as the compiled game has it, for partners that follow a policy of the file."""
        import jax

        from sjdsl.testing.states import compiled_state

        if self._blank is None:
            _, self._blank = self._env.reset(jax.random.key(0))
        return compiled_state(self._env, self._blank, world)


def load_trained(name: str, opened: Opened, root: Path) -> Trained:
    """Returns a policy by its name, ready to act in a game.

    root: the folder that it must be in. Raises PolicyRefused: it is not there, of another game, does not fit, or cannot be loaded.
    """
    file = policy_file(root, name, opened.game.name)
    from sjdsl.library.factory import environment_of
    from sjdsl.trainers import PolicyError, load_policy

    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        try:
            env = environment_of(opened.build, {})
            policy = load_policy(file, env)
        except PolicyError as error:
            raise PolicyRefused(str(error)) from None
        except CompileError as error:
            raise PolicyRefused(f"`{name}` needs the compiled game: {error.diagnostics[0].message}") from None
    told = [str(note.message) for note in notes if issubclass(note.category, UserWarning)]
    return Trained(name, "; ".join(told), env, policy)


def _shape(game: ir.Game) -> tuple[Any, ...]:
    """Returns all that a network is made for: agents, actions, and the planes and window of observations."""
    window, described = game.window, [(plane.name, plane.encoding, plane.labels) for plane in planes(game)]
    sides = (window.ahead, window.behind, window.left, window.right)
    return game.name, game.agents.number, game.agents.actions, bool(game.agents.forbids), described, sides


def _roles(game: ir.Game) -> bool:
    return any(field.name == "role" for field in game.agents.fields)
