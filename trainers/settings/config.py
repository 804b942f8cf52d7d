"""The configuration of a training run: a frozen model with all settings, defaults and checks."""

import math
import operator
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    NonNegativeFloat,
    NonNegativeInt,
    PositiveFloat,
    PositiveInt,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from sjdsl.near_names import meant

from .config_errors import ConfigError, sentence_of
from .extensions import (
    BUILT_IN,
    Kind,
    RewardMode,
    absolute_name,
    find,
    is_own,
    name_of,
    require_allowed,
    with_article,
)
from .own_settings import OWN, Own, flatten_own, gather_own, missing_own, unread_own
from .policy_names import absolute_policy_name, split_name

__all__ = ["Config", "ConfigError", "PPOConfig", "VDNConfig", "make_config"]

MOST_SEEDS = 2**16  # in one run; each has a folder
TO_ACT: tuple[Kind, ...] = ("algorithm", "network")  # the hooks that acting alone uses
# JAX uses the lower 32 bits of a seed, so a larger one would repeat the run of a smaller one.
LARGEST_SEED = 2**32 - MOST_SEEDS


class Source(NamedTuple):
    """Where values come from: the context of pydantic's validators."""

    asked: Collection[str] | None = None  # the settings that the user has set; None: all
    stored: bool = False  # they come from a file


def _is_stored(info: ValidationInfo) -> bool:
    return info.context is not None and info.context.stored


def _whole_number(value: Any) -> Any:
    """Returns `1e6` and `"1e6"` as 1000000; anything else unchanged."""
    if isinstance(value, bool | int):
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        return value
    return int(number) if number.is_integer() else value


def _listed(value: Any) -> Any:
    """Returns `"45, 90"` and `45` as lists; anything else unchanged."""
    if isinstance(value, str):
        return [part.strip() for part in value.split(",") if part.strip()]
    if isinstance(value, int | float):
        return [value]
    return value


def _require_odd(value: int) -> int:
    if value % 2 == 0:
        raise ValueError("odd, so that a window has a middle")
    return value


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    """Returns the names in alphabetical order, as their order means nothing."""
    if len(set(names)) < len(names):
        raise ValueError("names, each of them once")
    return tuple(sorted(names))


def _hook_validator(kind: Kind, *names: str) -> BeforeValidator:
    """Returns a check that a value is one of `names`, by default the built-in ones, or custom code.

    A function gets a name, and a name is looked up at once; but names in a stored configuration are
    not, as that would run their code.
    """
    built_in = names or BUILT_IN[kind]

    def check(value: Any, info: ValidationInfo) -> Any:
        """Returns the name of a hook. Raises ValueError for anything else."""
        if callable(value):
            return name_of(kind, value)
        if isinstance(value, str) and (value in built_in or _is_stored(info)):
            return value
        if not isinstance(value, str) or not is_own(kind, value):
            listed = ", ".join(map(repr, built_in))
            raise ValueError(
                f"{listed}, the name of {with_article(kind)} that was registered, or FILE.py:NAME"
            )
        name = absolute_name(kind, value)
        find(kind, name)
        return name

    return BeforeValidator(check)


def _partner_pairs(value: Any, info: ValidationInfo) -> Any:
    """Returns partners as pairs of an agent's number and its policy's name, sorted.

    Args:
      value: `{1: "random"}`, such pairs, or `"1,2=random,3=runs/a"`, also in parts.
    """
    if _is_stored(info):  # checked before it was stored, with full paths
        return value
    if isinstance(value, list | tuple) and value and all(isinstance(part, str) for part in value):
        value = ",".join(value)
    try:
        if isinstance(value, str):
            value = _read_partners(value)
        if isinstance(value, Mapping):
            value = value.items()
        pairs = [(_agent_number(agent), policy) for agent, policy in value]
    except (TypeError, ValueError):
        raise ValueError(
            "of the form AGENT=POLICY, such as 1=random or 1,2=runs/a, in Python {1: 'random'}"
        ) from None
    return tuple(sorted((agent, absolute_policy_name(policy)) for agent, policy in pairs))


def _read_partners(text: str) -> dict[int, str]:
    """Returns the partners of `1,2=random,3=runs/a`. Raises ValueError for another text."""
    part = r"\s*([\d,\s]+)=([^,]+)"
    if not re.fullmatch(f"({part}(,|$))+", text):
        raise ValueError
    return {
        int(agent): policy.strip()
        for agents, policy in re.findall(part, text)
        for agent in agents.strip(", ").split(",")
    }


def _agent_number(agent: Any) -> int:
    """Returns an agent's number, of a text or a whole number. Raises ValueError, TypeError."""
    return int(agent) if isinstance(agent, str) else operator.index(agent)


@dataclass(frozen=True)
class Only:
    """Annotates a setting that is used only if another setting has certain values."""

    setting: str  # the other one
    values: str  # its values, in words
    # whether a configuration, or any object with its fields, has one of them
    holds: Callable[[Any], bool]


def only(setting: str, *values: str) -> Only:
    """Annotates a setting that is used only if `setting` has one of these values."""
    return Only(setting, " or ".join(values), lambda config: getattr(config, setting) in values)


def _policy_name(value: Any, info: ValidationInfo) -> Any:
    """Returns a policy's name as it works from every folder; a stored one is that already."""
    return value if _is_stored(info) else absolute_policy_name(value)


# at most 2^53, as larger numbers are not exact floats
Count = Annotated[PositiveInt, Field(le=2**53), BeforeValidator(_whole_number)]
CountOrZero = Annotated[NonNegativeInt, BeforeValidator(_whole_number)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
PositiveFraction = Annotated[float, Field(gt=0.0, le=1.0)]
Angles = Annotated[
    tuple[Annotated[float, Field(ge=-180.0, le=180.0)], ...],
    Field(min_length=1),
    BeforeValidator(_listed),
]
Sides = Annotated[
    tuple[Annotated[PositiveInt, AfterValidator(_require_odd)], ...],
    Field(min_length=1),
    BeforeValidator(_listed),
]
Reads = Annotated[
    tuple[Literal["action", "reward", "trial"], ...],
    BeforeValidator(_listed),
    AfterValidator(_each_once),
]
Horizons = Annotated[
    tuple[Annotated[float, Field(ge=1.0)], ...],
    BeforeValidator(_listed),
]
Partners = Annotated[tuple[tuple[NonNegativeInt, str], ...], BeforeValidator(_partner_pairs)]

COMMON = only("reward", "common")
SVO = only("reward", "svo")
EXCHANGE = only("reward", "exchange")
INEQUITY = only("reward", "inequity")
TRACES = Only(
    "reward",
    "svo or one of your own",
    lambda config: config.reward not in get_args(RewardMode) or config.reward == "svo",
)
SCALED = only("reward", "individual", "svo", "exchange", "inequity")
CNN = only("network", "cnn")
MAPPO = only("algorithm", "mappo")
ONE_TORSO = Only(
    "critic", "pooled", lambda config: config.algorithm != "mappo" or config.critic == "pooled"
)
REMEMBERED = only("memory", "gru")
BUFFER = only("replay", "buffer")
ROLLOUT = only("replay", "none")
BY_TIME = Only("checkpoint_updates", "0", lambda config: not config.checkpoint_updates)
EVALUATED = Only("evaluate_every", "1 or more", lambda config: config.evaluate_every > 0)


class Config(BaseModel):
    """The settings common to all algorithms. Steps are environment steps, which move all agents."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    algorithm: str
    seed: Annotated[CountOrZero, Field(le=LARGEST_SEED)] = 0
    # runs side by side, with seeds `seed`, `seed` + 1 and so on
    seeds: Annotated[Count, Field(le=MOST_SEEDS)] = 1
    # environment steps of each seed, rounded up to whole updates
    total_timesteps: Count = 10_000_000
    num_envs: Count = 64
    num_steps: Count = 128  # steps of one rollout
    # environments start at different steps of an episode, so that each rollout covers all of it
    spread_starts: bool = True
    gamma: Fraction = 0.99
    learning_rate: PositiveFloat
    anneal_learning_rate: bool = True  # linearly to zero over the run
    max_gradient_norm: PositiveFloat = 0.5
    # added to the root of squared gradients; a larger one slows layers with small gradients
    adam_epsilon: PositiveFloat = 1e-8

    # the policy whose parameters the run starts with; "": random ones
    init_from: Annotated[str, BeforeValidator(_policy_name)] = ""
    partners: Partners = ()  # (agent, policy): agents that act by a fixed policy and don't learn

    # or a custom one, of a `Step`
    reward: Annotated[str, _hook_validator("reward")] = "individual"
    common_reward: Annotated[Literal["sum", "mean"], COMMON] = "sum"
    # decay per step of the reward traces that svo compares; 0: this step's rewards
    reward_smoothing: Annotated[Fraction, TRACES] = 0.0
    # target angle in degrees; one for all agents or one each
    svo_angle: Annotated[Angles, SVO] = (90.0,)
    svo_weight: Annotated[NonNegativeFloat, SVO] = 0.5
    # the angle while nobody is rewarded: 0, or the target
    svo_at_rest: Annotated[Literal["selfish", "content"], SVO] = "selfish"
    # clip angles to 0 .. 90 degrees, the range of the theory
    svo_quadrant: Annotated[bool, SVO] = True
    # weight of each other agent's reward relative to one's own: 0 individual, 1 the mean
    exchange_ratio: Annotated[Fraction, EXCHANGE] = 0.5
    inequity_envy: Annotated[NonNegativeFloat, INEQUITY] = 5.0  # weight of others having more
    inequity_guilt: Annotated[NonNegativeFloat, INEQUITY] = 0.05  # weight of others having less
    # lambda: traces decay by gamma x lambda per step; 0: this step's rewards
    inequity_smoothing: Annotated[Fraction, INEQUITY] = 0.975
    # scale rewards by the number of agents, as in the released code
    match_socialjax: Annotated[bool, SCALED] = False

    # networks also read the agent's number, so that agents who share one can differ
    agent_id: bool = False
    mask_actions: bool = True  # exclude forbidden actions from drawing, values and learning

    # or a custom one, of tokens
    network: Annotated[str, _hook_validator("network")] = "cnn"
    network_width: Count = 64  # units of each hidden dense layer
    # kernel side of each convolution in cells, in order
    convolution_sides: Annotated[Sides, CNN] = (5, 3, 3)
    convolution_channels: Annotated[Count, CNN] = 32  # output channels of each convolution
    precision: Literal["float32", "bfloat16"] = "float32"  # of the layers; parameters stay float32
    own: Own = ()  # (name, value): settings of a custom algorithm, loss, network or reward

    # at least, between two checkpoints
    checkpoint_minutes: Annotated[NonNegativeFloat, BY_TIME] = 10.0
    # the largest share of time spent on writing checkpoints
    checkpoint_share: Annotated[PositiveFraction, BY_TIME] = 0.05
    # instead: updates between checkpoints, however long writing takes; 0: by time
    checkpoint_updates: CountOrZero = 0
    policy_every: CountOrZero = 0  # updates between numbered policies; 0: a twentieth of the run
    keep_policies: CountOrZero = 5  # how many of the latest are kept; 0: all
    evaluate_every: CountOrZero = 0  # updates between evaluations; 0: none during the run
    evaluation_episodes: Annotated[Count, EVALUATED] = 30

    @model_validator(mode="wrap")
    @classmethod
    def _explain(cls, values: Any, validate: Any, info: ValidationInfo) -> "Config":
        """Returns the configuration. Raises ConfigError with a sentence for each wrong setting."""
        try:
            config: Config = validate(values)
        except ValidationError as error:
            # the first of each key, as a wrong number in a list is no list either
            faults = {fault["loc"][:1]: fault for fault in reversed(error.errors())}
            sentences = [sentence_of(fault, cls.model_fields, KEYS_OF) for fault in faults.values()]
            raise ConfigError("\n".join(reversed(sentences))) from None
        asked = config.model_fields_set
        if info.context is not None and info.context.asked is not None:
            asked = info.context.asked
        config._refuse_unread(asked, _is_stored(info))
        return config

    def _refuse_unread(self, asked: Collection[str], stored: bool) -> None:
        """Raises ConfigError for settings that the user has set but nothing uses.

        Records (of `record` or `model_dump`) and stored configurations have all settings, so there
        unused ones may have their defaults.
        """
        fields = type(self).model_fields
        are_all_set = all(name in asked for name in dependent_settings(type(self)))
        if asked and (stored or are_all_set):
            asked = [name for name in fields if getattr(self, name) != fields[name].default]
        faults = [
            f"`{name}` has no effect while `{condition.setting}` is "
            f"{getattr(self, condition.setting)}: "
            f"set `{condition.setting}` to {condition.values}, or leave `{name}` out"
            for name, condition in self.unread.items()
            if name in asked
        ]
        if not stored:  # stored code is not imported here
            for name, message in unread_own(self.hooks, self.own).items():
                if "own" in asked or OWN + name in asked:
                    faults.append(message)
            faults += missing_own(self.hooks, self.own)
        if faults:
            raise ConfigError("\n".join(faults))

    @property
    def unread(self) -> dict[str, Only]:
        """The settings that have no effect here, each with its condition."""
        return {
            name: condition
            for name, condition in dependent_settings(type(self)).items()
            if not condition.holds(self)
        }

    @property
    def hooks(self) -> dict[Kind, str]:
        """The names of the custom algorithm, loss, network and reward."""
        hooks = {}
        for kind, built_in in BUILT_IN.items():
            name = getattr(self, kind, built_in[0])
            if name not in built_in:
                hooks[kind] = name
        return hooks

    def record(self) -> dict[str, Any]:
        """Returns all settings as JSON values, as in manifests and policies.

        Those that have no effect are at their defaults.
        """
        defaults = {name: type(self).model_fields[name].default for name in self.unread}
        return self.model_copy(update=defaults).model_dump(mode="json")

    @property
    def steps_per_update(self) -> int:
        """Environment steps of one update."""
        return self.num_envs * self.num_steps

    @property
    def num_updates(self) -> int:
        """Updates of the whole run."""
        return math.ceil(self.total_timesteps / self.steps_per_update)

    @property
    def policy_updates(self) -> int:
        """Updates between numbered policies.

        If nothing is evaluated, the best policy is chosen by the episodes of so many updates.
        """
        return self.policy_every or max(1, self.num_updates // 20)

    @property
    def seed_numbers(self) -> tuple[int, ...]:
        """The seeds of the runs side by side."""
        return tuple(range(self.seed, self.seed + self.seeds))


class PPOConfig(Config):
    """Proximal policy optimisation whose critics read an agent's window (ippo), or all (mappo)."""

    # or a custom one
    algorithm: Annotated[str, _hook_validator("algorithm", "ippo", "mappo")] = "ippo"
    # or a custom one, of a minibatch
    loss: Annotated[str, _hook_validator("loss")] = "ppo"
    learning_rate: PositiveFloat = 5e-4
    num_epochs: Count = 2
    num_minibatches: Count = 8
    gae_lambda: Fraction = 0.95
    # the least standard deviation that a minibatch's advantages are divided by
    advantage_floor: NonNegativeFloat = 0.03
    clip_epsilon: PositiveFloat = 0.2
    scale_clip_epsilon: bool = False  # divide clip_epsilon by the number of agents
    clip_value_loss: bool = False
    # critics predict in units of the running mean and deviation of their targets
    normalise_values: bool = False
    entropy_coefficient: NonNegativeFloat = 0.01
    value_coefficient: NonNegativeFloat = 0.5
    # the deviation of random preferences that agents of one environment share during a rollout, in
    # the last environment at the start of a run (trainers/algorithms/preferences.py)
    preference_noise: NonNegativeFloat = 0.0

    # actor and critic have a hidden layer in common after the torso, instead of one each
    share_hidden: Annotated[bool, ONE_TORSO] = False
    # critics also read the averages of what their agent has learnt from lately, its shaped rewards,
    # over about so many steps
    reward_horizons: Annotated[Horizons, ONE_TORSO] = ()
    # what a critic reads: in a network of its own, all agents' windows, or the state; or `pooled`,
    # what the actors' network makes of the agent's window, and the mean of that over all agents
    critic: Annotated[Literal["observations", "state", "pooled"], MAPPO] = "observations"
    sharing: Literal["shared", "per_agent"] = "shared"  # whether agents share a network
    memory: Literal["none", "gru"] = "none"
    # what agents with memory also read: their last action and reward; `trial`: whether a trial of
    # several in an episode, or the episode, starts
    memory_reads: Annotated[Reads, REMEMBERED] = ()

    @property
    def critic_has_torso(self) -> bool:
        """Whether the critic shares no layer with its actor."""
        return self.algorithm == "mappo" and self.critic != "pooled"


def _require_common(reward: Any) -> Any:
    if reward != "common":
        raise ValueError("'common' with VDN, whose agents learn from the sum of all rewards")
    return reward


class VDNConfig(Config):
    """Value decomposition networks: Q-learning of the sum of the agents' values."""

    algorithm: Literal["vdn"] = "vdn"
    learning_rate: PositiveFloat = 7e-5
    max_gradient_norm: PositiveFloat = 1.0
    num_envs: Count = 32
    num_steps: Count = 1
    reward: Annotated[Literal["common"], BeforeValidator(_require_common)] = "common"
    match_socialjax: bool = False  # the team's reward is multiplied by the number of agents
    # learn from steps drawn from a buffer, or from each rollout as it was played
    replay: Literal["buffer", "none"] = "buffer"
    layer_norm: bool = False  # of each hidden layer
    # environment steps in the replay buffer; a multiple of num_envs x num_steps
    buffer_size: Annotated[Count, BUFFER] = 102_400
    batch_size: Annotated[Count, BUFFER] = 128
    gradient_steps: Annotated[Count, BUFFER] = 4  # of one update
    # environment steps before the first gradient step
    learning_starts: Annotated[CountOrZero, BUFFER] = 1000
    double_q: Annotated[bool, BUFFER] = False
    target_update_every: Annotated[Count, BUFFER] = 10  # updates
    # how far the target moves towards the network
    target_rate: Annotated[PositiveFraction, BUFFER] = 1.0
    num_epochs: Annotated[Count, ROLLOUT] = 1
    num_minibatches: Annotated[Count, ROLLOUT] = 8
    q_lambda: Annotated[Fraction, ROLLOUT] = 0.9  # weight of longer returns
    epsilon_start: Fraction = 1.0
    epsilon_end: Fraction = 0.05
    # of the run, until epsilon_end is reached
    epsilon_fraction: PositiveFraction = 0.1


CLASSES: Mapping[str, type[Config]] = {"ippo": PPOConfig, "mappo": PPOConfig, "vdn": VDNConfig}
KEYS_OF: Mapping[str, Mapping[str, Any]] = {
    algorithm: kind.model_fields for algorithm, kind in CLASSES.items()
}


def dependent_settings(kind: type[Config]) -> dict[str, Only]:
    """Returns the settings that are not always used, each with its condition."""
    return {
        name: annotation
        for name, field in kind.model_fields.items()
        for annotation in field.metadata
        if isinstance(annotation, Only)
    }


def only_of_others(name: str, kind: type[Config]) -> bool:
    """Whether a setting is one of other algorithms only, and not of this class."""
    return name not in kind.model_fields and any(name in keys for keys in KEYS_OF.values())


def make_config(
    values: Mapping[str, Any] | None = None, *, asked: Collection[str] | None = None, **more: Any
) -> Config:
    """Returns the configuration of the algorithm that `values` name; ippo by default.

    Args:
      values, more: settings.
      asked: those that the user has set; others, from a preset or a stored policy, are dropped if
        nothing uses them. None: all.
    Raises:
      ConfigError: an unknown algorithm or key, a wrong value, or a setting that the user has set
        and nothing uses; one line for each.
    """
    return _read_config({**(values or {}), **more}, Source(asked))


def stored_config(values: Any, strict: bool = False) -> Config:
    """Returns a configuration stored with a run or a policy.

    The code that it names isn't imported. Settings that nothing uses are dropped; if `strict`, they
    are refused unless they have their defaults.

    Raises:
      ConfigError: it isn't valid in this version; one line for each fault.
    """
    if not isinstance(values, Mapping):
        raise ConfigError(f"a configuration has keys and values, not {type(values).__name__}")
    return _read_config(values, Source(None if strict else (), stored=True))


def require_code(config: Config, place: str, to_act: bool) -> None:
    """Raises NotAllowed unless the caller has allowed the code that a stored configuration names.

    Args:
      place: where it is stored.
      to_act: whether the policy only acts, so that losses and rewards aren't used.
    """
    for kind, name in code_of(config, to_act):
        require_allowed(kind, name, place)


def code_of(config: Config, to_act: bool) -> Iterator[tuple[Kind, str]]:
    """Yields the kind and the name of what a configuration may have of the user's code.

    Args:
      to_act: whether the policy only acts, so that losses and rewards aren't used.
    """
    for kind, name in config.hooks.items():
        if not to_act or kind in TO_ACT:
            yield kind, name
    for _, policy in config.partners:
        path, _ = split_name(policy)
        if not path.exists():
            yield "policy", policy


def class_of(algorithm: Any) -> type[Config]:
    """Returns the configuration class of an algorithm; for a custom one, that of PPO.

    Raises:
      ConfigError: the name is unknown.
    """
    if callable(algorithm) or (isinstance(algorithm, str) and is_own("algorithm", algorithm)):
        return PPOConfig
    if not isinstance(algorithm, str) or algorithm not in CLASSES:
        raise ConfigError(
            f"unknown algorithm {algorithm!r}{meant(str(algorithm), CLASSES, 'known:')}"
        )
    return CLASSES[algorithm]


def _read_config(settings: Mapping[str, Any], source: Source) -> Config:
    """Returns the configuration of settings, without those that nothing uses and nobody asked for.

    Raises ConfigError.
    """
    values = {"algorithm": "ippo", **flatten_own(settings)}
    kind = class_of(values["algorithm"])
    if source.asked is not None and not source.stored:
        values = {
            name: value
            for name, value in values.items()
            if name in source.asked or not only_of_others(name, kind)
        }
    config = kind.model_validate(gather_own(values), context=source)
    if source.asked is None:
        return config
    unread = set(config.unread)
    if not source.stored:
        unread |= {OWN + name for name in unread_own(config.hooks, config.own)}
    kept = {
        name: value for name, value in values.items() if name not in unread or name in source.asked
    }
    return kind.model_validate(gather_own(kept), context=source)
