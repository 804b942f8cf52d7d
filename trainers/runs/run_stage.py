"""A stage of a run: it has its environment and settings, and continues from the one before."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..environment import Environment
from ..settings.config import Config
from ..settings.extensions import short_name


@dataclass(frozen=True)
class RunStage:
    """A stage of a run in its folder, or a run without stages."""

    env: Environment
    config: Config
    folder: Path
    manifest: dict[str, Any]  # updated as the run goes on
    number: int = 0  # of the stage, from 1; 0: the run has no stages
    before: "RunStage | None" = None

    def steps_after(self, update: int) -> int:
        """Returns the environment steps of each seed until the end of an update, in all stages."""
        steps_before = 0 if self.before is None else self.before.all_steps
        return steps_before + update * self.config.steps_per_update

    @property
    def all_steps(self) -> int:
        """Environment steps of each seed until the end of this stage."""
        return self.steps_after(self.config.num_updates)

    @property
    def title(self) -> str:
        """The stage in words, for people who watch it."""
        algorithm = short_name(self.config.algorithm)
        reward = short_name(self.config.reward)
        title = f"{self.env.name}, {algorithm}, {reward} reward"
        return f"{title}, stage {self.number}" if self.number else title

    @property
    def seed_folders(self) -> tuple[Path, ...]:
        """The folder of each seed: the stage's own for one seed, `seed_N` in it for several."""
        if self.config.seeds == 1:
            return (self.folder,)
        return tuple(self.folder / f"seed_{number}" for number in self.config.seed_numbers)
