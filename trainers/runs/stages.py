"""The names and the folders of a run's stages."""

from pathlib import Path

from ..settings.stage_settings import STAGES

FROM_STAGES = " from stages"


def reward_label(reward: str, from_stages: bool) -> str:
    """Returns the reward of a run in a table: after stages, it isn't the same as from scratch."""
    return f"{reward}{FROM_STAGES}" if from_stages else reward


def stage_folders(folder: Path) -> list[Path]:
    """Returns the folders of all stages of a run, or of one of its seeds, in order.

    Args:
      folder: of the last stage.
    """
    is_seed = folder.name.startswith("seed_") and not (folder / STAGES).is_dir()
    run_dir = folder.parent if is_seed else folder
    numbers = [int(path.name) for path in (run_dir / STAGES).glob("*") if path.name.isdecimal()]
    in_stage = folder.relative_to(run_dir)  # the folder of the seed in each stage, if it is one
    earlier = [run_dir / STAGES / str(number) / in_stage for number in sorted(numbers)]
    return [*earlier, folder]
