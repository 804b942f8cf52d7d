"""`sjdsl record`: stores episodes under a policy as a file of arrays, for offline learning or
replay.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.asked_episodes import asked_policy, calls_beside, host_of, require_model
from sjdsl.cli.environment_options import (
    EnvironmentOptions,
    environment_options,
    make_environment,
)
from sjdsl.cli.episode_options import SEED_OF_FIRST, episodes_option, seed_option
from sjdsl.cli.folders import require_folder_of, require_unused
from sjdsl.cli.model_options import limit_options
from sjdsl.cli.policies import SIDE_BY_SIDE, check_policy, choose_policy, code_option, policy_option
from sjdsl.cli.stages import LOADING, Say, stages
from sjdsl.models import HostPolicy, Limits, Talks
from sjdsl.models.recorded import reasons
from sjdsl.replay import DatasetWriter, Episode, Header
from sjdsl.replay.recording import with_tasks_played
from sjdsl.trainers.settings.policy_names import UNTRAINED, split_name

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

Play = Callable[["Environment", Header], Iterator[Episode]]
PACKAGES = ("sjdsl", "jax", "numpy")
REPORTED = 100  # episodes between two lines of progress


@click.command("record")
@click.argument("game")
@click.option(
    "-o", "output", metavar="FILE", help="The new .npz file to write; by default GAME.npz."
)
@policy_option
@code_option
@episodes_option(10, "Episodes to play.")
@seed_option(SEED_OF_FIRST)
@click.option(
    "--observation",
    type=click.Choice(["tokens", "onehot", "none"]),
    default="tokens",
    show_default=True,
    help="How to store observations.",
)
@environment_options
@limit_options
def command(
    game: str,
    output: str | None,
    policy: str,
    episodes: int,
    seed: int,
    observation: str,
    options: EnvironmentOptions,
    limits: Limits,
) -> None:
    """Plays GAME and stores observations, actions and rewards of whole episodes."""
    path = Path(output or f"{Path(game).stem}.npz")
    if path.suffix != ".npz":
        raise click.UsageError(f"`{path}` must end in .npz")
    if seed + episodes > 2**32:
        raise click.UsageError(
            f"the seeds go up to {seed + episodes - 1}, and the largest seed is {2**32 - 1}"
        )
    check_policy(policy, options.check(game))
    require_unused(path, "recorded episodes")
    require_folder_of(path)
    arguments = options.describe(game)
    require_model(limits, [policy])
    host = host_of(policy)
    with stages(LOADING) as say, ExitStack() as stack:
        env = make_environment(arguments)
        if host is None:
            play = partial(_play_compiled, choose_policy(policy, env))
        else:
            calls = calls_beside(path, policy, env, seed, limits, say)
            play = partial(_play_asked, host, stack.enter_context(calls))
        planes = {
            "onehot": list(env.channel_names),
            "tokens": [plane.name for plane in env.token_planes],
            "none": [],
        }
        header = Header(
            game=env.name,
            environment=with_tasks_played(arguments, env.game.task),
            hash=env.hash,
            policy=policy,
            policy_digest=_digest(policy),
            seed=seed,
            episodes=episodes,
            observation=observation,  # type: ignore[arg-type]
            planes=planes[observation],
            action_names=list(env.action_names),
            versions={name: version(name) for name in PACKAGES},
        )
        summary = write_episodes(env, play, header, path, say)
    click.echo(summary)


def _play_compiled(policy: Any, env: "Environment", header: Header) -> Iterator[Episode]:
    """Yields the episodes of a header under a policy."""
    from sjdsl.replay import play_episodes

    return play_episodes(env, policy, header.seed, header.episodes, header.observation)


def _play_asked(
    host: HostPolicy, talks: Talks, env: "Environment", header: Header
) -> Iterator[Episode]:
    """Yields the episodes of a header, in which all agents ask a host; calls are recorded."""
    import numpy as np

    from sjdsl.replay import play_asked_episodes

    policy_of = partial(asked_policy, env, host, talks)
    assert talks.folder is not None
    played = play_asked_episodes(env, policy_of, header.seed, header.episodes, header.observation)
    for episode in played:
        folder = talks.folder / f"seed_{episode.seed}"
        why = reasons(folder, 0, *episode.actions.shape)
        yield replace(episode, why=np.array(why))


def write_episodes(env: "Environment", play: Play, header: Header, path: Path, say: Say) -> str:
    """Plays and writes the episodes of a header; returns a summary.

    If this is interrupted, the episodes so far are stored, and their summary is printed.
    """
    writer = DatasetWriter(path, header)
    try:
        with writer:
            say(f"playing {header.episodes} episodes of {env.title or env.name}")
            for number, episode in enumerate(play(env, header), 1):
                writer.add(episode)
                if number % REPORTED == 0 and number < header.episodes:
                    say(f"{number} of {header.episodes} episodes written")
    except KeyboardInterrupt:
        if writer.returns:
            click.echo(
                f"interrupted; the episodes so far are stored\n{_summary(env, path, writer)}"
            )
        raise
    return _summary(env, path, writer)


def _summary(env: "Environment", path: Path, writer: "DatasetWriter") -> str:
    """Returns two lines: how much was stored, and the returns of these episodes."""
    import numpy as np

    collective = np.array(writer.returns).sum(axis=1)
    num_bytes = path.stat().st_size
    size = f"{num_bytes / 1e6:.1f} MB" if num_bytes >= 1e6 else f"{num_bytes / 1e3:.0f} kB"
    episodes = f"{len(collective)} episodes of {env.title or env.name}"
    return (
        f"{path}  {episodes}, {writer.steps} steps, {size}\n"
        f"collective return: mean {collective.mean():g}, lowest {collective.min():g}, "
        f"highest {collective.max():g}"
    )


def _digest(policy: str) -> str | None:
    """Returns the SHA-256 of the file that a policy is stored in; None if it isn't stored."""
    path, which = split_name(policy)
    if policy in (*UNTRAINED, SIDE_BY_SIDE) or not path.exists():
        return None
    from sjdsl.trainers.policies.policy_file import policy_path

    return hashlib.sha256(policy_path(path, which).read_bytes()).hexdigest()
