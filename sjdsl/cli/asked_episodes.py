"""Episodes in which all agents ask one policy in words, with its calls beside the file that they
are written to.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.policies import SIDE_BY_SIDE
from sjdsl.cli.stages import Say
from sjdsl.experiments.folder import record_experiment, require_same
from sjdsl.models import HostPolicy, Limits, Talks
from sjdsl.trainers.settings.policy_names import UNTRAINED

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment


def host_of(name: str) -> HostPolicy | None:
    """Returns the policy of this name if it is asked in words; None for every other."""
    if name in (*UNTRAINED, SIDE_BY_SIDE):
        return None
    from sjdsl.trainers.policies.loading import find_host

    return find_host(name)


def require_model(limits: Limits, names: Iterable[str]) -> None:
    """Raises UsageError for limits of calls if no policy of these names is asked in words."""
    if limits != Limits() and not any(host_of(name) for name in names):
        raise click.UsageError(
            "--parallel, --budget and --calls are for language models, and none plays"
        )


@contextmanager
def calls_beside(
    path: Path, name: str, env: "Environment", seed: int, limits: Limits, say: Say
) -> Iterator[Talks]:
    """Yields what asks a policy, and records its calls in the folder `NAME_models` beside a file.

    Commands with the same game, policy and seed share them.

    Raises:
      ExperimentError: the folder holds others.
    """
    from sjdsl.experiments.players import find_pool
    from sjdsl.trainers.runs.run_folder import describe_game

    folder = path.with_name(f"{path.stem}_models")
    description = {
        "experiment": "episodes",
        "game": describe_game(env),
        "policies": [find_pool(name, env).describe()],
        "seed": seed,
    }
    require_same(folder, description)
    record_experiment(folder, description)
    with Talks(folder, limits, say) as talks:
        yield talks


def asked_policy(env: "Environment", host: HostPolicy, talks: Talks, seed: int) -> Any:
    """Returns the policy of all agents in the episodes of `seed`, `seed + 1`, …, one by one."""
    from sjdsl.models.hosted import hosted_policy
    from sjdsl.runtime.policy import mixed_policy

    return hosted_policy(
        env,
        dict.fromkeys(range(env.num_agents), host),
        mixed_policy(env.num_agents, []),
        lambda number: talks.part(f"seed_{seed + number}"),
        talks.limits.parallel,
    )
