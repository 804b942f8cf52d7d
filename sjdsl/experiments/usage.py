"""What the models of an experiment were asked, in words and as JSON values; and what they would be
asked.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import jax
import numpy as np

from sjdsl.experiments.playing import Experiment
from sjdsl.models import HostPolicy, Model, Reply, Seats
from sjdsl.models.account import Usage, tokens
from sjdsl.models.seats import Question
from sjdsl.trainers.environment import episode_length, num_trials

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
            notes = num_trials(env) - 1 if policy.notebook else 0
            seats = members[index] * experiment.episodes * experiment.replicates
            calls = seats * (episode_length(env) + notes)
            result[pool.name] = Forecast(policy, calls, _first_tokens(experiment, policy))
    return result


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


def describe_usage(usage: Mapping[str, Usage]) -> dict[str, Any]:
    """Returns `models`, what each was asked, as JSON values; nothing if none played."""
    return {"models": {name: asdict(used) for name, used in usage.items()}} if usage else {}


def too_many_invalid(usage: Mapping[str, Usage]) -> str:
    """Returns which models gave more than 5 % of replies that couldn't be used; empty if none did."""
    shares = [
        f"{100 * used.invalid_share:.2g} % of the replies of {name}"
        for name, used in usage.items()
        if used.invalid_share > MOST_INVALID_SHARE
    ]
    return f"{' and '.join(shares)} could not be used, and counted as `stay`" if shares else ""


def usage_text(usage: Mapping[str, Usage]) -> str:
    """Returns what models were asked, in words; empty if none played."""
    if not usage:
        return ""
    lines = [
        f"  {name}: {used.calls:,} calls, {used.invalid:,} of them with replies that could not be "
        f"used, {used.input:,} tokens in ({used.cached:,} cached), {used.output:,} out, "
        f"${used.dollars:.4f}"
        for name, used in usage.items()
    ]
    title = (
        "models, each of them one subject: the intervals are over episodes, not over models or "
        "prompts"
    )
    return "\n".join(["", title, *lines])
