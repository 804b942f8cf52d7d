"""The outcome of the training behind a stored policy: whether it has ended, and who diverged."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..policies.policy_file import PolicyError
from .manifest import MANIFEST, read_manifest
from .run_errors import RunError

FINISHED = "finished"


@dataclass(frozen=True)
class RunState:
    """The outcome of a run's training, from its manifest."""

    status: str  # `finished`, `running`, `interrupted`, `failed: …` or why it stopped
    diverged: Mapping[int, int]  # seed -> the update in which its loss was not finite

    @property
    def unfinished(self) -> str:
        """Why it may not have ended, in words; empty if it has, or if seeds have diverged."""
        return "" if self.status == FINISHED or self.diverged else self.status


def run_state(folder: Path) -> RunState | None:
    """Returns the outcome of a run's training, or None without a manifest.

    Args:
      folder: of a run, or `seed_N` in it for that of one seed.
    Raises:
      PolicyError: there is a manifest that can't be read, so that the policies may be incomplete.
    """
    file = folder / MANIFEST
    seed = folder.name.removeprefix("seed_")
    is_seed = folder.name.startswith("seed_") and seed.isdecimal() and not file.is_file()
    if is_seed:
        file = folder.parent / MANIFEST
    if not file.is_file():
        return None
    try:
        manifest = read_manifest(file.parent)
    except RunError as error:
        raise PolicyError(f"{error}, so the run may not have ended") from None
    diverged = {entry["seed"]: entry["update"] for entry in manifest.get("diverged", ())}
    if is_seed:
        diverged = {number: diverged[number] for number in diverged if number == int(seed)}
    return RunState(manifest.get("status", FINISHED), diverged)
