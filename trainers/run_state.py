"""How the training that a stored policy is of has gone: whether it has ended, and which of its seeds have diverged."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sjdsl.files import read_json

from .manifest import MANIFEST
from .policy_file import PolicyError

FINISHED = "finished"


@dataclass(frozen=True)
class RunState:
    """What the manifest of a run says of its training. `status`: `finished`, `running`, `interrupted`, `failed: …` or why it stopped."""

    status: str
    diverged: Mapping[int, int]  # seed -> the update in which its loss was not finite

    @property
    def unfinished(self) -> str:
        """Why it is not known to have ended, in words; empty where it has, and where single seeds have diverged, which is another matter."""
        return "" if self.status == FINISHED or self.diverged else self.status


def run_state(folder: Path) -> RunState | None:
    """Returns how the training of a run has gone, or of the run that a folder `seed_N` is in, then of that seed; None without a manifest.

    Raises:
      PolicyError: the manifest is there and cannot be read: whether its policies are whole cannot be told.
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
        raise PolicyError(f"{file} cannot be read ({type(error).__name__}: {error}): whether the run has ended cannot be told") from None
    if file is own:
        return RunState(status, diverged)
    return RunState(status, {number: update for number, update in diverged.items() if number == int(seed)})
