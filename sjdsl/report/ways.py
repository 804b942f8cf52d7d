"""The ways of training that tables ask for, as questions about a run, and their names in words."""

from collections.abc import Callable

from sjdsl.report.evidence import Run
from sjdsl.trainers.extensions import short_name

Way = Callable[[Run], bool]
SHARED, APART = "shared", "per_agent"


def is_ippo(run: Run, sharing: str = SHARED) -> bool:
    """Returns whether a run is of IPPO, its agents with one network or with one each."""
    return run.algorithm == "ippo" and run.sharing == sharing


def individual(run: Run) -> bool:
    """IPPO, each agent its own reward."""
    return is_ippo(run) and run.reward == "individual"


def common(run: Run) -> bool:
    """IPPO, the sum or the mean of all rewards (`common_reward`)."""
    return is_ippo(run) and run.reward == "common"


def mappo(run: Run) -> bool:
    """MAPPO, the sum of all rewards, as in the released configurations."""
    return run.algorithm == "mappo" and run.sharing == SHARED and run.reward == "common"


def vdn(run: Run) -> bool:
    """VDN, which always learns from the sum of all rewards."""
    return run.algorithm == "vdn"


def exchanged(ratio: float) -> Way:
    """IPPO with exchanged rewards; 0 is individual and 1 common reward, as the protocol `exchange` has them."""
    if ratio == 0:
        return individual
    if ratio == 1:
        return common
    return lambda run: is_ippo(run) and run.exchange_ratio == ratio


def svo(angle: float, weight: float, stage: int | None = None) -> Way:
    """IPPO with SVO at an angle and a weight; `stage`: 1 or 2 of a sweep, whose seeds are never taken for those of the other."""
    return lambda run: is_ippo(run) and run.svo_angle == angle and run.svo_weight == weight and run.stage in (stage, None)


CHOSEN_WEIGHT = "chosen weight"
NAMES = {"ippo": "IPPO", "mappo": "MAPPO", "irat": "IRAT", "vdn": "VDN"}


def in_words(run: Run, chosen_weight: float | None = None) -> str:
    """Returns a way of training in words: `IPPO, exchange 0.5`, `IPPO, SVO 45°, weight 0.4`, `MAPPO, common, separate parameters`.

    Args:
      run: the way of training.
      chosen_weight: the weight of SVO that a sweep chose for the game. Where it is given, runs with it that did not choose it are called by
        that, `IPPO, SVO 45°, chosen weight`: one way in all games, though the weights differ.
    """
    name = NAMES.get(run.algorithm, short_name(run.algorithm))
    if run.algorithm == "vdn":
        return name
    rewards = {
        "exchange": f"exchange {run.exchange_ratio:g}" if run.exchange_ratio is not None else "exchange",
        "svo": _svo(run, chosen_weight),
    }
    sharing = {SHARED: "", APART: ", separate parameters"}.get(run.sharing, f", parameters {run.sharing.replace('_', ' ')}")
    return f"{name}, {rewards.get(run.reward, short_name(run.reward))}{sharing}"


def _svo(run: Run, chosen_weight: float | None) -> str:
    angle = "several angles" if run.svo_angle is None else f"{run.svo_angle:g}°"
    if run.stage == 2 and run.svo_weight == chosen_weight:
        return f"SVO {angle}, {CHOSEN_WEIGHT}"
    stage = ", choosing the weight" if run.stage == 1 else ""
    return f"SVO {angle}, weight {run.svo_weight or 0:g}{stage}"
