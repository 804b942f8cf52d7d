"""The outcome of the training behind a stored policy: whether it has ended, and which seeds have diverged."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sjdsl.files import read_json

from ..policies.policy_file import PolicyError
from .manifest import MANIFEST

FINISHED = "finished"


@dataclass(frozen=True)
class RunState:
    """The outcome of a run's training, from its manifest. `status`: `finished`, `running`, `interrupted`, `failed: …` or why it stopped."""

    status: str
    diverged: Mapping[int, int]  # seed -> the update in which its loss was not finite

    @property
    def unfinished(self) -> str:
        """Why it may not have ended, in words; empty if it has, and if only single seeds have diverged."""
        return "" if self.status == FINISHED or self.diverged else self.status


def run_state(folder: Path) -> RunState | None:
    """Returns the outcome of a run's training, or of one seed's if the folder is `seed_N` of a run; None without a manifest.

    Raises:
      PolicyError: there is a manifest that can't be read, so that the policies may be incomplete.
    """
    own = folder / MANIFEST
    seed = folder.name.removeprefix("seed_") if folder.name.startswith("seed_") else ""
    file = folder.parent / MANIFEST if seed.isdecimal() and not own.is_file() else own
    if not file.is_file():
        return None
    try:
        manifest = read_json(file)
        diverged = {entry["seed"]: entry["update"] for entry in manifest.get("diverged", [])}
        status = str(manifest.get("status", FINISHED))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise PolicyError(
            f"{file} can't be read ({type(error).__name__}: {error}), so the run may not have ended"
        ) from None
    if file is own:
        return RunState(status, diverged)
    return RunState(
        status, {number: update for number, update in diverged.items() if number == int(seed)}
    )
