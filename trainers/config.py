"""The configuration of a training run: checked once, then never changed."""

import difflib
import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    NonNegativeFloat,
    NonNegativeInt,
    PositiveFloat,
    PositiveInt,
    ValidationError,
    model_validator,
)


class ConfigError(Exception):
    """A wrong key or value; the message has one line a fault."""


def _whole_number(value: Any) -> Any:
    """Returns `1e6` and `"1e6"` as 1000000; anything else as it came."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return value
    return int(number) if not isinstance(value, bool | int) and number.is_integer() else value


Count = Annotated[PositiveInt, BeforeValidator(_whole_number)]
CountOrZero = Annotated[NonNegativeInt, BeforeValidator(_whole_number)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]


class Config(BaseModel):
    """Everything a run depends on besides the game. Steps are environment steps: one step moves all agents."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    seed: CountOrZero = 0
    total_timesteps: Count = 10_000_000  # environment steps, rounded up to whole updates
    num_envs: Count = 64
    num_steps: Count = 128  # steps of one rollout
    num_epochs: Count = 2
    num_minibatches: Count = 8

    learning_rate: PositiveFloat = 5e-4
    anneal_learning_rate: bool = True  # linearly to zero over the run
    gamma: Fraction = 0.99
    gae_lambda: Fraction = 0.95
    clip_epsilon: PositiveFloat = 0.2
    clip_value_loss: bool = True
    entropy_coefficient: NonNegativeFloat = 0.01
    value_coefficient: NonNegativeFloat = 0.5
    max_gradient_norm: PositiveFloat = 0.5

    reward: Literal["individual", "common"] = "common"
    network: Literal["mlp", "cnn"] = "cnn"
    network_width: Count = 64  # units of each hidden dense layer

    checkpoint_every: CountOrZero = 50  # updates; 0 keeps only the last parameters

    @model_validator(mode="wrap")
    @classmethod
    def _explain(cls, values: Any, validate: Any) -> "Config":
        try:
            return validate(values)
        except ValidationError as error:
            raise ConfigError("\n".join(_sentence(fault) for fault in error.errors())) from None

    @property
    def steps_per_update(self) -> int:
        """Environment steps of one update."""
        return self.num_envs * self.num_steps

    @property
    def num_updates(self) -> int:
        """Updates of the whole run."""
        return math.ceil(self.total_timesteps / self.steps_per_update)


def _sentence(fault: Mapping[str, Any]) -> str:
    """Returns one of pydantic's faults in the user's words."""
    key = str(fault["loc"][0]) if fault["loc"] else "config"
    match fault["type"]:
        case "extra_forbidden":
            return f"unknown key `{key}`{nearest_key(key, Config.model_fields)}"
        case "greater_than":
            need = f"more than {fault['ctx']['gt']}"
        case "greater_than_equal":
            need = f"at least {fault['ctx']['ge']}"
        case "less_than_equal":
            need = f"at most {fault['ctx']['le']}"
        case "literal_error":
            need = fault["ctx"]["expected"]
        case "int_parsing" | "int_type" | "int_from_float":
            need = "a whole number"
        case "float_parsing" | "float_type" | "finite_number":
            need = "a finite number"
        case "bool_parsing" | "bool_type":
            need = "true or false"
        case _:
            need = fault["msg"]
    return f"`{key}` must be {need}, not {fault['input']!r}"


def nearest_key(key: str, known: Mapping[str, Any]) -> str:
    """Returns `; did you mean …?`, or the list of known keys when none is near."""
    near = difflib.get_close_matches(key, known, n=1)
    return f"; did you mean `{near[0]}`?" if near else f"; known: {', '.join(known)}"
