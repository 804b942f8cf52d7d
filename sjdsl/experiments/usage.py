"""What the models of an experiment were asked, in words and as JSON values; and what they would be
asked.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any, cast

import jax
import numpy as np

from sjdsl.experiments.folder import require_same
from sjdsl.experiments.playing import Experiment, Part, part_name
from sjdsl.experiments.stacks import find_hosts
from sjdsl.models import HostPolicy, Limits, Model, Reply, Seats
from sjdsl.models.account import Account, Usage, tokens
from sjdsl.models.asking import Question
from sjdsl.models.recorded import FOLDER, file_of, read_talks, read_unanswered
from sjdsl.models.roles import wordings
from sjdsl.trainers.environment import episode_length, num_trials
from sjdsl.trainers.policies.estimates import Estimate, estimate

MOST_INVALID_SHARE = 0.05  # of the replies of a model, above which there is no verdict


@dataclass(frozen=True)
class Forecast:
    """What a model is asked at most: so many calls, each about as long as the first one."""

    policy: HostPolicy
    calls: int
    input: int  # tokens of a call

    def text(self) -> str:
        """Returns calls, tokens and dollars in words."""
        text = f"at most {self.calls:,} calls of about {self.input:,} tokens"
        if not isinstance(self.policy, Model):
            return text
        text += f", each answered with at most {self.policy.max_tokens:,}"
        if self.policy.price is None:
            return f"{text}; no price is given"
        sent = self.policy.dollars(self.input, 0, 0) * self.calls
        answers = self.policy.dollars(0, 0, self.policy.max_tokens) * self.calls
        return f"{text}; about ${sent:,.2f} for what is sent, at most ${answers:,.2f} for answers"


def forecasts(experiment: Experiment) -> dict[str, Forecast]:
    """Returns by name what each model of an experiment is asked at most; asks nobody."""
    env = experiment.env
    members = Counter(index for lineup in experiment.lineups for index in lineup)
    result = {}
    for index, pool in enumerate(experiment.pools):
        policy = pool.players[0].host
        if policy is not None:
            seats = members[index] * experiment.episodes * experiment.replicates
            calls = seats * _calls_of_a_seat(env, policy)
            result[pool.name] = Forecast(policy, calls, _first_tokens(experiment, policy))
    return result


def _calls_of_a_seat(env: Any, policy: HostPolicy) -> int:
    """Returns how often an agent is asked in an episode at most."""
    notes = num_trials(env) - 1 if policy.notebook else 0
    return episode_length(env) + notes


def status_text(experiment: Experiment, folder: Path, description: Mapping[str, Any]) -> str:
    """Returns how far the calls of an experiment are, which may be running: by model, role, trial.

    Args:
      folder: of its results; description: everything that they depend on.

    Raises:
      ExperimentError: the folder holds another experiment.
    """
    require_same(folder, description)
    account = Account(Limits())
    most = 0
    for lineup, replicate in product(experiment.lineups, range(experiment.replicates)):
        part = part_name(lineup, replicate)
        players = experiment.players(lineup, replicate)
        for episode, hosts in enumerate(find_hosts(players, experiment.orders(replicate))):
            for agent, policy in hosts.items():
                most += _calls_of_a_seat(experiment.env, policy)
                path = file_of(folder / FOLDER / part, episode, agent)
                for talk in read_talks(path).values():
                    account.recall(talk)
    unanswered = read_unanswered(folder / FOLDER).text()
    lines = [f"{folder}: {account.total().calls:,} calls, of at most {most:,}{unanswered}"]
    for (model, role, trial), used in sorted(account.usage.items()):
        name = f"{model}+{role}" if role else model
        lines.append(f"  {name}, trial {trial}: {_figures(used)}")
    return "\n".join(lines)


def _first_tokens(experiment: Experiment, policy: HostPolicy) -> int:
    """Returns about how many tokens the longest first message to an agent has."""
    env: Any = experiment.env
    lengths = [0]

    def measured(question: Question) -> Reply:
        lengths.append(tokens(question.message))
        return Reply(question.message.allowed[0])

    observation, state = env.reset(jax.random.key(experiment.seed))
    allowed = np.asarray(env.allowed_actions(state))[None]
    hosts = dict.fromkeys(range(env.num_agents), policy)
    with Seats(env, [hosts], measured) as seats:
        seats.choose(np.asarray(observation)[None], allowed, np.zeros(1, bool))
    return max(lengths)


def by_wording(experiment: Experiment, parts: Sequence[Part]) -> dict[str, tuple[Estimate, ...]]:
    """Returns the mean return of an agent of each model that plays a role, for each wording of it
    that was played, over the episodes of all line-ups.
    """
    estimates = {}
    for index, pool in enumerate(experiment.pools):
        policy = pool.players[0].host
        if policy is None or not policy.role:
            continue
        of_role = wordings(policy.role, cast(Any, experiment.env).game)
        played = min(len(of_role), experiment.episodes)
        means = [
            part.returns[:, np.array(part.lineup) == index].mean(axis=1)
            for part in parts
            if index in part.lineup
        ]
        estimates[pool.name] = tuple(
            estimate(np.concatenate([of_part[wording :: len(of_role)] for of_part in means]))
            for wording in range(played)
        )
    return estimates


def describe_usage(
    usage: Mapping[str, Usage], of_wordings: Mapping[str, Sequence[Estimate]] | None = None
) -> dict[str, Any]:
    """Returns `models`, what each was asked, and `wordings` of roles as JSON values; nothing if
    none played.
    """
    described: dict[str, Any] = {}
    if usage:
        described["models"] = {name: asdict(used) for name, used in usage.items()}
    if of_wordings:
        described["wordings"] = {
            name: [asdict(figure) for figure in figures] for name, figures in of_wordings.items()
        }
    return described


def too_many_invalid(usage: Mapping[str, Usage]) -> str:
    """Returns which models gave more than 5 % of replies that couldn't be used; empty if none did."""
    shares = [
        f"{100 * used.invalid_share:.2g} % of the replies of {name}"
        for name, used in usage.items()
        if used.invalid_share > MOST_INVALID_SHARE
    ]
    return f"{' and '.join(shares)} could not be used, and counted as `stay`" if shares else ""


def _figures(used: Usage) -> str:
    return (
        f"{used.calls:,} calls, {used.invalid:,} of them with replies that could not be used, "
        f"{used.input:,} tokens in ({used.cached:,} cached), {used.output:,} out, "
        f"${used.dollars:.4f}"
    )


def usage_text(
    usage: Mapping[str, Usage], of_wordings: Mapping[str, Sequence[Estimate]] | None = None
) -> str:
    """Returns what models were asked, and earned by wordings, in words; empty if none played."""
    if not usage:
        return ""
    lines = [f"  {name}: {_figures(used)}" for name, used in usage.items()]
    for name, figures in (of_wordings or {}).items():
        means = ", ".join(f"{figure.mean:.4g}" for figure in figures)
        lines.append(f"  {name}: return of an agent by wording of its role: {means}")
    title = (
        "models, each of them one subject: the intervals are over episodes, not over models or "
        "prompts"
    )
    return "\n".join(["", title, *lines])
