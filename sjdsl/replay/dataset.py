"""A dataset of many episodes in one `.npz` file: observations, actions, rewards, and how they were made."""

import io
import json
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from sjdsl.files import written_whole
from sjdsl.replay.episode import Episode, Observation
from sjdsl.replay.recording import Recording, RecordingError, read_recording

SUFFIX = ".npz"
HEADER = "header"


class Header(BaseModel):
    """What a file of episodes says of itself; JSON with these names.

    environment: the arguments of `sjdsl.make`, `variant` among them; hash: of the rules; policy: as it was named, policy_digest: SHA-256
    of its file, where it has one; seed: of the first episode, the next have `seed + 1`, …; planes: of an observation, by name;
    versions: of the packages that played.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal["sjdsl-episodes-1"] = "sjdsl-episodes-1"
    game: str
    environment: dict[str, Any]
    hash: str
    policy: str
    policy_digest: str | None
    seed: int
    episodes: int
    observation: Observation
    planes: list[str]
    action_names: list[str]
    versions: dict[str, str]


class DatasetWriter:
    """Writes episodes one by one; the file is there, whole, once the writer is closed.

    Used with `with`. If it is left by an interruption, the file has the episodes that were added; by another exception, there is no file.
    The same episodes give the same bytes.
    """

    def __init__(self, path: Path, header: Header) -> None:
        """Begins a file. `header`: its number of episodes is replaced by how many are added."""
        self.path, self._header = path, header
        self._open = ExitStack()
        self._zip = zipfile.ZipFile(self._open.enter_context(written_whole(path)), "w", zipfile.ZIP_DEFLATED, allowZip64=True)
        self.returns: list[np.ndarray] = []
        self.steps = 0

    def add(self, episode: Episode) -> None:
        """Appends an episode."""
        place = f"episode_{len(self.returns):05d}"
        arrays = {"actions": episode.actions, "rewards": episode.rewards}
        arrays |= {"terminated": np.array(episode.terminated), "truncated": np.array(episode.truncated), "seed": np.array(episode.seed)}
        if episode.observations is not None:
            arrays["observations"] = episode.observations
        arrays |= {f"events/{name}": count for name, count in episode.events.items()}
        for name, array in arrays.items():
            self._write(f"{place}/{name}", array)
        self.returns.append(episode.returns)
        self.steps += len(episode.actions)

    def __enter__(self) -> "DatasetWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        wanted = kind is None or (issubclass(kind, KeyboardInterrupt) and bool(self.returns))
        if wanted:
            header = self._header.model_copy(update={"episodes": len(self.returns)})
            self._write("returns", np.array(self.returns))
            self._write(HEADER, np.array(header.model_dump_json()))
        self._zip.close()
        self._open.__exit__(*((None, None, None) if wanted else (kind, error, trace)))

    def _write(self, name: str, array: np.ndarray) -> None:
        member = zipfile.ZipInfo(f"{name}.npy")  # without the time of day
        member.compress_type = zipfile.ZIP_DEFLATED
        with self._zip.open(member, "w", force_zip64=True) as file:
            np.lib.format.write_array(file, np.ascontiguousarray(array) if array.ndim else array, allow_pickle=False)


class Dataset:
    """A file of episodes, read one at a time.

    Attributes:
      header; returns: `[E, N]` float64.
    """

    def __init__(self, path: Path | str) -> None:
        """Opens a file.

        Raises:
          RecordingError: it cannot be read, or holds something else.
        """
        self.path = Path(path)
        try:
            with zipfile.ZipFile(self.path) as file:
                self._names = set(file.namelist())
                self.header = Header.model_validate_json(str(_read(file, HEADER)))
                self.returns = _read(file, "returns")
        except OSError as error:
            raise RecordingError(f"{path} cannot be read: {error.strerror}") from None
        except (zipfile.BadZipFile, KeyError, ValueError, ValidationError):
            raise RecordingError(f"{path} holds no recorded episodes; `sjdsl record GAME -o {self.path.name}` writes some") from None

    def __len__(self) -> int:
        return self.header.episodes

    def __iter__(self) -> Iterator[Episode]:
        return (self[number] for number in range(len(self)))

    def __getitem__(self, number: int) -> Episode:
        """Returns an episode, from 0; negative numbers count from the end.

        Raises:
          IndexError: there are not so many. RecordingError: the file is damaged.
        """
        if not -len(self) <= number < len(self):
            raise IndexError(f"{self.path} has no episode {number}: it has {len(self)}, counted from 0")
        place = f"episode_{number % len(self):05d}/"
        try:
            with zipfile.ZipFile(self.path) as file:
                parts = {name: _read(file, place + name) for name in self._parts(place)}
            events = {name.removeprefix("events/"): parts.pop(name) for name in list(parts) if name.startswith("events/")}
            seed, terminated, truncated = int(parts.pop("seed")), bool(parts.pop("terminated")), bool(parts.pop("truncated"))
            seen = parts.pop("observations", None)
            return Episode(seed=seed, observations=seen, events=events, terminated=terminated, truncated=truncated, **parts)
        except (zipfile.BadZipFile, KeyError, ValueError, TypeError, OSError) as error:
            raise RecordingError(f"episode {number} of {self.path} cannot be read: {error}") from None

    def recording(self, number: int) -> Recording:
        """Returns an episode as one that can be played again."""
        return self[number].recording(self.header.environment, self.header.hash)

    def _parts(self, place: str) -> Iterable[str]:
        return [name.removeprefix(place).removesuffix(".npy") for name in sorted(self._names) if name.startswith(place)]


def is_dataset(path: Path) -> bool:
    """Returns whether a file looks like one of many episodes."""
    return zipfile.is_zipfile(path)


def _read(file: zipfile.ZipFile, name: str) -> np.ndarray:
    return np.lib.format.read_array(io.BytesIO(file.read(f"{name}.npy")), allow_pickle=False)


def describe(header: Header) -> str:
    """Returns what a file was made with, a line each."""
    kept = header.model_dump()
    kept["versions"] = ", ".join(f"{name} {version}" for name, version in header.versions.items())
    kept["environment"] = json.dumps(header.environment)
    wanted = ("game", "hash", "environment", "policy", "policy_digest", "seed", "episodes", "observation", "versions")
    return "\n".join(f"{name.replace('_', ' ')}: {kept[name]}" for name in wanted if kept[name] is not None)


def load_recording(path: Path, episode: int = 0) -> Recording:
    """Returns an episode of a file that `sjdsl play --record` or `sjdsl record` wrote. `episode`: its number in the file, from 0.

    Raises:
      RecordingError: there is no such file, no such episode, or something else in it.
    """
    if path.is_file() and is_dataset(path):
        try:
            return Dataset(path).recording(episode)
        except IndexError as error:
            raise RecordingError(str(error)) from None
    recording = read_recording(path)
    if episode != 0:
        raise RecordingError(f"{path} has no episode {episode}: it has one, number 0")
    return recording
