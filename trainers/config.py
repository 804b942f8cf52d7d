"""The configuration of a training run: a frozen dataclass with every key, its default, and checks of its values."""

import math
import operator
import re
from collections.abc import Callable, Collection, Mapping
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

from .config_errors import RETIRED, ConfigError, sentence_of
from .extensions import Kind, a, find, is_own, lasting, name_of, require_allowed
from .own_settings import OWN, Own, gathered, missing_own, spread, unread_own
from .policy_names import lasting_name, split_name

__all__ = ["Config", "ConfigError", "PPOConfig", "VDNConfig", "make_config"]

Algorithm = Literal["ippo", "mappo", "irat", "vdn"]
RewardMode = Literal["individual", "common", "svo", "exchange", "inequity"]
NetworkKind = Literal["mlp", "cnn"]
# What a configuration may name one's own instead of, and which settings of `own` that may then take.
BUNDLED: Mapping[Kind, tuple[str, ...]] = {
    "algorithm": get_args(Algorithm),
    "loss": ("ppo",),
    "network": get_args(NetworkKind),
    "reward": get_args(RewardMode),
}
MOST_SEEDS = 2**16  # of one run: each has a folder
TO_ACT: tuple[Kind, ...] = ("algorithm", "network")  # the hooks that are used where nothing is learnt
SEEDS = 2**32  # how many there are: JAX makes a key of the lower 32 bits, so that a larger seed would be another's run


class Given(NamedTuple):
    """Where values come from, as pydantic's context. asked: the settings that somebody asked for now; None: all. stored: they are a file's."""

    asked: Collection[str] | None = None
    stored: bool = False


def _is_stored(info: ValidationInfo) -> bool:
    return info.context is not None and info.context.stored


def _whole_number(value: Any) -> Any:
    """Returns `1e6` and `"1e6"` as 1000000; anything else as it came."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        return value
    return int(number) if not isinstance(value, bool | int) and number.is_integer() else value


def _listed(value: Any) -> Any:
    """Returns `"45, 90"` and `45` as lists; anything else as it came."""
    if isinstance(value, str):
        return [part.strip() for part in value.split(",") if part.strip()]
    return [value] if isinstance(value, int | float) else value


def _span(value: Any) -> Any:
    """Returns one number as a span that stays where it is, two as they came."""
    listed = _listed(value)
    if not isinstance(listed, list | tuple) or len(listed) not in (1, 2):
        raise ValueError("one number, or two: at the start and at the end of the run")
    return (*listed, *listed) if len(listed) == 1 else listed


def _odd(value: int) -> int:
    if value % 2 == 0:
        raise ValueError("odd, so that a window has a middle")
    return value


def _one_of_or_own(kind: Kind, names: tuple[str, ...]) -> Callable[[Any, ValidationInfo], Any]:
    """Returns a check of `names` and of what users bring along: a function that is passed gets a name, and what is named is found at once.

    In a stored configuration names stay names: to find them would run their code.
    """

    def check(value: Any, given: ValidationInfo) -> Any:
        if _is_stored(given) and isinstance(value, str):
            return value
        if callable(value):
            return name_of(kind, value)
        if not isinstance(value, str) or (value not in names and not is_own(kind, value)):
            raise ValueError(f"{', '.join(map(repr, names))}, the name of {a(kind)} that was registered, or FILE.py:NAME")
        if value not in names:
            value = lasting(kind, value)
            find(kind, value)
        return value

    return check


def _partners(value: Any, given: ValidationInfo) -> Any:
    """Returns partners, `{1: "random"}` or `"1,2=random,3=runs/a"`, as pairs of an agent's number and its policy's name."""
    if isinstance(value, str):
        parts = re.findall(r"\s*([\d,\s]+)=([^,]+)", value)
        if not value.strip() or re.sub(r"\s*([\d,\s]+)=([^,]+)(,|$)", "", value):
            raise ValueError("of the form AGENT=POLICY, such as 1=random or 1,2=runs/a")
        value = {int(agent): policy.strip() for agents, policy in parts for agent in agents.replace(" ", "").strip(",").split(",")}
    if _is_stored(given):  # as it was checked and written, with whole paths
        return value
    if isinstance(value, Mapping):
        value = value.items()
    return tuple(sorted((int(agent), lasting_name(policy)) for agent, policy in value))


@dataclass(frozen=True)
class Only:
    """Beside the type of a setting: that it is read only where another setting has certain values."""

    setting: str
    values: str  # in words
    holds: Callable[[Any], bool]


def only(setting: str, *values: str) -> Only:
    """Returns that a setting is read only where another has one of some values."""
    return Only(setting, " or ".join(values), lambda value: value in values)


def _policy_name(value: Any, given: ValidationInfo) -> Any:
    return value if _is_stored(given) else lasting_name(value)


Count = Annotated[PositiveInt, Field(le=2**53), BeforeValidator(_whole_number)]  # more is no exact float
CountOrZero = Annotated[NonNegativeInt, BeforeValidator(_whole_number)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Angles = Annotated[tuple[Annotated[float, Field(ge=-180.0, le=180.0)], ...], Field(min_length=1), BeforeValidator(_listed)]
Sides = Annotated[tuple[Annotated[PositiveInt, AfterValidator(_odd)], ...], Field(min_length=1), BeforeValidator(_listed)]
Span = Annotated[tuple[NonNegativeFloat, NonNegativeFloat], BeforeValidator(_span)]  # from the start to the end of the run, linearly
Groups = Annotated[tuple[NonNegativeInt, ...], BeforeValidator(_listed)]
Partners = Annotated[tuple[tuple[NonNegativeInt, str], ...], BeforeValidator(_partners)]

COMMON, SVO = only("reward", "common"), only("reward", "svo")
EXCHANGE, INEQUITY = only("reward", "exchange"), only("reward", "inequity")
TRACES = Only("reward", "svo or one of your own", lambda reward: reward not in get_args(RewardMode) or reward == "svo")
SCALED = only("reward", "individual", "svo", "exchange", "inequity")
CNN, MAPPO, IRAT = only("network", "cnn"), only("algorithm", "mappo"), only("algorithm", "irat")
CENTRAL = only("algorithm", "mappo", "irat")
ONE_POLICY = Only("algorithm", "ippo, mappo or one of your own", lambda algorithm: algorithm != "irat")
BY_TIME = Only("checkpoint_updates", "0", operator.not_)


class Config(BaseModel):
    """What every algorithm's run depends on besides the game. Steps are environment steps: one step moves all agents."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    algorithm: str
    seed: CountOrZero = 0
    seeds: Annotated[Count, Field(le=MOST_SEEDS)] = 1  # runs side by side, with `seed`, `seed` + 1 and so on
    total_timesteps: Count = 10_000_000  # environment steps of each seed, rounded up to whole updates
    num_envs: Count = 64
    num_steps: Count = 128  # steps of one rollout
    spread_starts: bool = True  # environments begin at different steps of an episode, so that each rollout sees all parts of it
    gamma: Fraction = 0.99
    learning_rate: PositiveFloat
    anneal_learning_rate: bool = True  # linearly to zero over the run
    max_gradient_norm: PositiveFloat = 0.5

    init_from: Annotated[str, BeforeValidator(_policy_name)] = ""  # the policy whose parameters the run starts with; "": drawn ones
    partners: Partners = ()  # (agent, policy): agents that act by a given policy and do not learn

    reward: Annotated[str, BeforeValidator(_one_of_or_own("reward", BUNDLED["reward"]))] = "individual"  # or one's own, of a `Step`
    common_reward: Annotated[Literal["sum", "mean"], COMMON] = "sum"
    reward_smoothing: Annotated[Fraction, TRACES] = 0.0  # decay a step of the reward traces that svo compares; 0: this step's rewards
    svo_angle: Annotated[Angles, SVO] = (90.0,)  # degrees, the angle sought; one for all agents or one each
    svo_weight: Annotated[NonNegativeFloat, SVO] = 0.5
    svo_at_rest: Annotated[Literal["selfish", "content"], SVO] = "selfish"  # the angle where nobody is rewarded: 0, or the one sought
    svo_quadrant: Annotated[bool, SVO] = True  # angles are cut to 0 .. 90 degrees, where the theory defines them
    exchange_ratio: Annotated[Fraction, EXCHANGE] = 0.5  # weight of each other agent's reward to one's own: 0 individual, 1 the mean
    inequity_envy: Annotated[NonNegativeFloat, INEQUITY] = 5.0  # weight of others having more
    inequity_guilt: Annotated[NonNegativeFloat, INEQUITY] = 0.05  # weight of others having less
    inequity_smoothing: Annotated[Fraction, INEQUITY] = 0.975  # lambda: traces fall by gamma x lambda a step; 0: this step's rewards
    match_socialjax: Annotated[bool, SCALED] = False  # rewards scaled by the number of agents, as the released code has them

    agent_id: bool = False  # networks read which agent it is besides what it sees: those who share one may come to differ
    mask_actions: bool = True  # an action that the game forbids now is not drawn, valued or learnt from

    network: Annotated[str, BeforeValidator(_one_of_or_own("network", BUNDLED["network"]))] = "cnn"  # or one's own, of tokens
    network_width: Count = 64  # units of each hidden dense layer
    convolution_sides: Annotated[Sides, CNN] = (5, 3, 3)  # cells along the side of each convolution's kernel, one after the other
    convolution_channels: Annotated[Count, CNN] = 32  # features that each gives a cell
    precision: Literal["float32", "bfloat16"] = "float32"  # of the network's layers; parameters stay float32
    own: Own = ()  # (name, value): settings that an algorithm, loss, network or reward of one's own takes by name

    checkpoint_minutes: Annotated[NonNegativeFloat, BY_TIME] = 10.0  # between two checkpoints, at least
    checkpoint_share: Annotated[float, Field(gt=0.0, le=1.0), BY_TIME] = 0.05  # of the time, at most, that writing checkpoints may take
    checkpoint_updates: CountOrZero = 0  # instead: one after so many updates, however long writing takes; 0: by time
    policy_every: CountOrZero = 0  # updates between policies stored by number; 0: a twentieth of the run
    keep_policies: CountOrZero = 5  # how many of them are kept, the last; 0: all
    evaluate_every: CountOrZero = 0  # updates; 0 only what the caller does at the end
    evaluation_episodes: Annotated[Count, Only("evaluate_every", "1 or more", bool)] = 30

    @model_validator(mode="wrap")
    @classmethod
    def _explain(cls, values: Any, validate: Any, info: ValidationInfo) -> "Config":
        try:
            config: Config = validate(values)
        except ValidationError as error:
            raise ConfigError("\n".join(sentence_of(fault, cls.model_fields, KEYS_OF) for fault in error.errors())) from None
        if config.seed + config.seeds > SEEDS:
            last = "" if config.seeds == 1 else f"; with seeds = {config.seeds} the last is {config.seed + config.seeds - 1}"
            raise ConfigError(f"`seed` must be below 2^32 = {SEEDS}, for random keys are made of 32 bits, not {config.seed}{last}")
        asked = info.context.asked if info.context is not None else None
        config._refuse_unread(config.model_fields_set if asked is None else asked, _is_stored(info))
        return config

    def _refuse_unread(self, asked: Collection[str], stored: bool) -> None:
        """Raises ConfigError for settings that were asked for and that nothing reads.

        A record, as of `record` or `model_dump`, has all of them, and nobody asks for all at once: there, and in what is stored, they may stand
        at their defaults.
        """
        fields = type(self).model_fields
        if asked and (stored or dependent_settings(type(self)).keys() <= set(asked)):
            asked = [name for name in fields if getattr(self, name) != fields[name].default]
        faults = [
            f"`{name}` does nothing where `{mark.setting}` is {getattr(self, mark.setting)}: set `{mark.setting}` to {mark.values}, or leave "
            f"`{name}` out"
            for name, mark in self.unread.items()
            if name in asked
        ]
        if not stored:  # else nothing is imported yet
            faults += [said for name, said in unread_own(self).items() if {"own", OWN + name} & {*asked}]
            faults += missing_own(self)
        if faults:
            raise ConfigError("\n".join(faults))

    @property
    def unread(self) -> dict[str, Only]:
        """The settings that nothing reads here, each with what would have it read."""
        return {name: mark for name, mark in dependent_settings(type(self)).items() if not mark.holds(getattr(self, mark.setting))}

    @property
    def hooks(self) -> dict[Kind, str]:
        """The names of one's own algorithm, loss, network and reward, where these are not bundled ones."""
        named = {kind: getattr(self, kind, bundled[0]) for kind, bundled in BUNDLED.items()}
        return {kind: name for kind, name in named.items() if name not in BUNDLED[kind]}

    def record(self) -> dict[str, Any]:
        """Returns all settings as values of JSON, as manifests and policies have them: those that nothing reads at their defaults."""
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
        """Updates between two policies stored by number; over as many, the best is looked for where nothing is evaluated."""
        return self.policy_every or max(1, self.num_updates // 20)

    @property
    def seed_numbers(self) -> tuple[int, ...]:
        """The seeds of the runs side by side."""
        return tuple(range(self.seed, self.seed + self.seeds))


class PPOConfig(Config):
    """Proximal policy optimisation: with a critic of what an agent sees (ippo), of what all see (mappo), or one of each (irat)."""

    algorithm: Annotated[str, BeforeValidator(_one_of_or_own("algorithm", ("ippo", "mappo", "irat")))] = "ippo"  # or one's own
    loss: Annotated[str, BeforeValidator(_one_of_or_own("loss", BUNDLED["loss"])), ONE_POLICY] = "ppo"  # or one's own, of a minibatch
    learning_rate: PositiveFloat = 5e-4
    num_epochs: Count = 2
    num_minibatches: Count = 8
    gae_lambda: Fraction = 0.95
    advantage_floor: NonNegativeFloat = 0.03  # the least deviation that a minibatch's advantages are divided by
    clip_epsilon: PositiveFloat = 0.2
    scale_clip_epsilon: bool = False  # divide it by the number of agents
    clip_value_loss: bool = True
    entropy_coefficient: NonNegativeFloat = 0.01
    value_coefficient: NonNegativeFloat = 0.5

    critic: Annotated[Literal["observations", "state"], CENTRAL] = "observations"  # it sees all agents' windows, or the world's state
    joint_optimiser: Annotated[bool, MAPPO] = False  # one optimiser and one gradient clip for actor and critic, as in ippo; else one each
    team_reward: Annotated[Literal["sum", "mean"], IRAT] = "mean"  # of all agents' raw rewards: what the team policies learn from
    similarity_clip: Annotated[Span, IRAT] = (3.0, 0.5)  # how far from 1 the individual policy's ratio to the team's counts
    individual_kl: Annotated[Span, IRAT] = (0.2, 2.0)  # weight of KL(team ‖ individual) in the individual policy's loss
    team_kl: Annotated[Span, IRAT] = (1.5, 0.0)  # weight of KL(individual ‖ team) in the team policy's loss
    sharing: Literal["shared", "per_agent", "by_role"] = "shared"  # which agents have one network
    roles: Annotated[Groups, only("sharing", "by_role")] = ()  # the role of each agent, as numbers from 0; empty: as the game has it
    memory: Literal["none", "gru"] = "none"


class VDNConfig(Config):
    """Value decomposition networks: Q-learning of the sum of the agents' values, from replayed steps."""

    algorithm: Literal["vdn"] = "vdn"
    learning_rate: PositiveFloat = 7e-5
    max_gradient_norm: PositiveFloat = 1.0
    num_envs: Count = 32
    num_steps: Count = 1
    reward: Literal["common"] = "common"
    match_socialjax: bool = False  # the team's reward is multiplied by the number of agents
    buffer_size: Count = 102_400  # environment steps replayed from; a multiple of num_envs x num_steps
    batch_size: Count = 128
    gradient_steps: Count = 4  # of one update
    learning_starts: CountOrZero = 1000  # environment steps before the first gradient step
    double_q: bool = False
    target_update_every: Count = 10  # updates
    target_rate: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0  # how much of the network its target takes over
    epsilon_start: Fraction = 1.0
    epsilon_end: Fraction = 0.05
    epsilon_fraction: Annotated[float, Field(gt=0.0, le=1.0)] = 0.1  # of the run, until epsilon_end is reached


CLASSES: Mapping[str, type[Config]] = {"ippo": PPOConfig, "mappo": PPOConfig, "irat": PPOConfig, "vdn": VDNConfig}
KEYS_OF: Mapping[str, Mapping[str, Any]] = {algorithm: kind.model_fields for algorithm, kind in CLASSES.items()}


def dependent_settings(kind: type[Config]) -> dict[str, Only]:
    """Returns the settings of a configuration that are not always read, each with when it is."""
    return {name: mark for name, field in kind.model_fields.items() for mark in field.metadata if isinstance(mark, Only)}


def make_config(values: Mapping[str, Any] | None = None, *, asked: Collection[str] | None = None, **more: Any) -> Config:
    """Returns the configuration of the algorithm that `values` name; ippo unless they do.

    Args:
      values, more: settings.
      asked: those that somebody asked for; others, as of a preset or of a stored policy, are left out where nothing reads them. None: all.
    Raises:
      ConfigError: an unknown algorithm or key, a wrong value, or a setting that was asked for and that nothing reads; one line a fault.
    """
    return _config({**(values or {}), **more}, Given(asked))


def stored_config(values: Any, strict: bool = False) -> Config:
    """Returns the configuration that a file of a run or of a policy holds; nothing that it names is imported.

    Settings that nothing reads are left out; or, if it is `strict`, refused unless they have their defaults.

    Raises:
      ConfigError: it is none of this version; one line a fault.
    """
    if not isinstance(values, Mapping):
        raise ConfigError(f"a configuration has keys and values, not {type(values).__name__}")
    return _config({key: value for key, value in values.items() if key not in RETIRED}, Given(None if strict else (), stored=True))


def require_code(config: Config, place: str, to_act: bool) -> None:
    """Checks that the caller has named the code of a stored configuration. Raises NotAllowed.

    Args:
      place: where it is stored.
      to_act: nothing is learnt, so neither losses nor rewards are going to be used.
    """
    for kind, name in config.hooks.items():
        if not to_act or kind in TO_ACT:
            require_allowed(kind, name, place)
    for _, policy in config.partners:
        if not split_name(policy)[0].exists():
            require_allowed("policy", policy, place)


def class_of(algorithm: Any) -> type[Config]:
    """Returns the class of configurations of an algorithm: of one's own that of PPO. Raises ConfigError where there is none of that name."""
    if callable(algorithm) or (isinstance(algorithm, str) and is_own("algorithm", algorithm)):
        return PPOConfig
    if not isinstance(algorithm, str) or algorithm not in CLASSES:
        raise ConfigError(f"unknown algorithm {algorithm!r}{meant(str(algorithm), CLASSES, 'known:')}")
    return CLASSES[algorithm]


def _config(given_values: Mapping[str, Any], given: Given) -> Config:
    values = {"algorithm": "ippo", **spread(given_values)}
    kind = class_of(values["algorithm"])
    config = kind.model_validate(gathered(values), context=given)
    if given.asked is None:
        return config
    unread = {*config.unread, *(() if given.stored else map(OWN.__add__, unread_own(config)))} - {*given.asked}
    return kind.model_validate(gathered({name: value for name, value in values.items() if name not in unread}), context=given)
