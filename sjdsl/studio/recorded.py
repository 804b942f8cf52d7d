"""The episode on the board as a file for `sjdsl replay`, like those of `sjdsl play --record`."""

from collections.abc import Sequence

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.interpreter.state import default_params
from sjdsl.library.checked_game import build_game
from sjdsl.library.games_folder import games_folder
from sjdsl.replay.recording import Recording, with_tasks_played
from sjdsl.studio.counterexample import plain
from sjdsl.studio.episode import Episode
from sjdsl.studio.opened import Opened


class CannotRecord(Exception):
    """No file can say how the episode was played; the message says what to change."""


def recording_of(
    episode: Episode,
    opened: Opened,
    players: Sequence[str],
    why: list[list[str]] | None = None,
) -> Recording:
    """Returns an episode as recorded. Raises CannotRecord.

    players: who played each agent; empty if that isn't known. why: their reasons, if they gave any.
    """
    if episode.is_put or episode.scenario is not None:
        raise CannotRecord(
            "this episode didn't begin with the start of the game, so it can't be played again "
            "from its seed: begin again to record one"
        )
    game = opened.game
    params = episode.moments[0].world.params
    if any(moment.world.params != params for moment in episode.moments):
        raise CannotRecord(
            "a number was changed during this episode: begin again to record one with the new "
            "number"
        )
    file = opened.source.file
    assert file is not None
    is_bundled = file.parent == games_folder().resolve()
    written = default_params(game)
    arguments = {
        "game": file.stem if is_bundled else str(file),
        "variant": "+".join(opened.composition.chosen) or None,
        "map": None,
        "num_agents": game.agents.number if opened.agents_are_free else None,
        "params": {name: plain(value) for name, value in params.items() if value != written[name]},
    }
    environment = with_tasks_played(arguments, game.task)
    try:
        saved, _ = build_game(**environment)
    except (CompileError, ValueError):
        saved = None
    if saved is None or game_hash(saved.game) != game_hash(game):
        raise CannotRecord(
            "the episode was played by rules that aren't in the file: save the game to record it"
        )
    return Recording(
        environment=environment,
        hash=game_hash(game),
        seed=episode.seed,
        actions=[list(moment.actions) for moment in episode.moments[1:]],
        returns=episode.returns[-1],
        players=list(players) or None,
        why=why,
    )
