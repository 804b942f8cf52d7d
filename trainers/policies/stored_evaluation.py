"""Reads the file of an evaluation, which `save_evaluation` writes."""

from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sjdsl.files import read_json

EVALUATION = "evaluation.json"  # of the last policy of a run or a seed
RETURN = "collective return"  # a figure that each evaluation has


class Figure(BaseModel):
    """A mean with its 95 % interval; None for what isn't defined."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)

    mean: float | None
    low: float | None
    high: float | None


class HeldOut(BaseModel):
    """The same policy in the held-out tasks of a split."""

    model_config = ConfigDict(strict=True)

    summary: dict[str, Figure]
    training_minus_held_out: Figure  # of the collective return


class StoredEvaluation(BaseModel):
    """What is read of an evaluation; the file also has the results of each episode."""

    model_config = ConfigDict(strict=True)

    policy: str | int
    update: int  # of the policy
    seed: int
    greedy: bool | None
    episodes: Annotated[int, Field(ge=1, lt=2**31)]
    summary: dict[str, Figure]
    held_out: dict[str, HeldOut] = {}  # by split


def read_evaluation(path: Path) -> StoredEvaluation | None:
    """Returns an evaluation; None if the file is missing, damaged or something else."""
    try:
        evaluation = StoredEvaluation.model_validate(read_json(path))
    except (OSError, ValidationError, ValueError):
        return None
    return evaluation if RETURN in evaluation.summary else None
