"""A dataset of episodes in one `.npz` file: observations, actions, rewards, and their origin."""

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, NonNegativeInt, ValidationError

from sjdsl.files import written_whole
from sjdsl.replay.arrays import FAULTS, TooLarge, array_digest, read_arrays
from sjdsl.replay.asked import asked_recording
from sjdsl.replay.episode import Episode, Observation
from sjdsl.replay.recording import Arguments, Recording, RecordingError, Seed, read_recording

SUFFIX = ".npz"
HEADER = "header"
LARGEST_HEADER = 2**20  # bytes
DIGEST_SIZE = 32  # bytes
SUMMARIES = ("returns", "digests")  # the arrays about all episodes
LARGEST = 2**30  # bytes of the arrays of one episode, and of the returns of all


class Header(BaseModel):
    """The header of a file of episodes; JSON with these names.

    environment: the arguments of `sjdsl.make`, including `variant`; hash: of the rules.
    policy: its name; policy_digest: the SHA-256 of its file, if any.
    seed: of the first episode, the next ones have `seed + 1`, …; planes: names, in order.
    versions: of the packages used; arrays: names of each episode's arrays.
    digests: the SHA-256 of the arrays `returns` and `digests`; the latter has the SHA-256 of every
    array of every episode.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal["sjdsl-episodes-1"] = "sjdsl-episodes-1"
    game: str
    environment: dict[str, Any]
    hash: str
    policy: str
    policy_digest: str | None
    seed: Seed
    episodes: NonNegativeInt
    observation: Observation
    planes: list[str]
    action_names: list[str]
    versions: dict[str, str]
    arrays: list[str] = []
    digests: dict[str, str] = {}


class DatasetWriter:
    """Writes episodes one by one, in a `with` block; the file appears when the block ends.

    After an interruption the file has the episodes added so far; after another exception there is
    no file. The same episodes give the same bytes.
    """

    def __init__(self, path: Path, header: Header) -> None:
        """Starts a file.

        Args:
          header: its number of episodes, `arrays` and `digests` are replaced at the end.
        """
        self.path = path
        self._header = header
        self._open = ExitStack()
        file = self._open.enter_context(written_whole(path))
        self._zip = zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, allowZip64=True)
        self.returns: list[np.ndarray] = []
        self.steps = 0
        self._names: list[str] = []
        self._digests: list[bytes] = []  # of each episode: those of its arrays

    def add(self, episode: Episode) -> None:
        """Appends an episode.

        Raises:
          ValueError: it is too large, or has other arrays than those before.
        """
        arrays = {
            "actions": episode.actions,
            "rewards": episode.rewards,
            "terminated": np.array(episode.terminated),
            "truncated": np.array(episode.truncated),
            "seed": np.array(episode.seed),
        }
        if episode.observations is not None:
            arrays["observations"] = episode.observations
        if episode.why is not None:
            arrays["why"] = episode.why
        arrays |= {f"events/{name}": count for name, count in episode.events.items()}
        size = sum(array.nbytes for array in arrays.values())
        if size > LARGEST // 2:  # leaves room for the arrays' headers, a few hundred bytes each
            raise ValueError(
                f"an episode of {size:,} bytes is too large for a file of episodes: record without "
                "observations"
            )
        if self.returns and [*arrays] != self._names:
            raise ValueError(
                f"the arrays of all episodes have the same names: {', '.join(self._names)}"
            )
        self._names = [*arrays]
        folder = _folder_of(len(self.returns))
        for name, array in arrays.items():
            self._write(f"{folder}/{name}", array)
        self._digests.append(b"".join(map(array_digest, arrays.values())))
        self.returns.append(episode.returns)
        self.steps += len(episode.actions)

    def __enter__(self) -> "DatasetWriter":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        is_interrupted = kind is not None and issubclass(kind, KeyboardInterrupt)
        is_kept = kind is None or (is_interrupted and len(self.returns) > 0)
        if not is_kept:
            with suppress(OSError):
                self._zip.close()
            self._open.__exit__(kind, error, trace)
            return
        with self._open:
            self._write_summaries()
            self._zip.close()

    def _write_summaries(self) -> None:
        """Writes the arrays about all episodes, and the header with their digests."""
        shape = (len(self.returns), len(self._names), DIGEST_SIZE)
        digests = np.frombuffer(b"".join(self._digests), np.uint8).reshape(shape)
        summaries = {"returns": np.array(self.returns), "digests": digests}
        for name, array in summaries.items():
            self._write(name, array)
        header = self._header.model_copy(
            update={
                "episodes": len(self.returns),
                "arrays": self._names,
                "digests": {name: array_digest(array).hex() for name, array in summaries.items()},
            }
        )
        self._write(HEADER, np.array(header.model_dump_json()))

    def _write(self, name: str, array: np.ndarray) -> None:
        member = zipfile.ZipInfo(f"{name}.npy")  # without the time of day
        member.compress_type = zipfile.ZIP_DEFLATED
        if array.ndim:
            array = np.ascontiguousarray(array)
        with self._zip.open(member, "w", force_zip64=True) as file:
            np.lib.format.write_array(file, array, allow_pickle=False)


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
                header = read_arrays(file, [HEADER], LARGEST_HEADER)[HEADER]
                self.header = Header.model_validate_json(str(header))
                summaries = read_arrays(file, SUMMARIES, LARGEST)
        except TooLarge as error:
            raise RecordingError(f"{path} cannot be read: {error}") from None
        except OSError as error:
            raise RecordingError(f"{path} cannot be read: {error.strerror}") from None
        except FAULTS:
            raise RecordingError(
                f"{path} holds no recorded episodes; `sjdsl record GAME -o {self.path.name}` "
                "writes some"
            ) from None
        self.returns = summaries["returns"]
        self._digests = summaries["digests"]
        episodes = self.header.episodes
        is_valid = self.returns.ndim == 2 and self.returns.dtype == np.float64
        if not is_valid or len(self.returns) != episodes:
            raise RecordingError(
                f"{path} is damaged: it doesn't hold the returns of {episodes} episodes"
            )
        self._check_members(summaries)

    def __len__(self) -> int:
        return self.header.episodes

    def __iter__(self) -> Iterator[Episode]:
        return (self[number] for number in range(len(self)))

    def __getitem__(self, number: int) -> Episode:
        """Returns an episode, from 0; negative numbers count from the end.

        Raises:
          IndexError: there are fewer episodes. RecordingError: the file is damaged.
        """
        if not -len(self) <= number < len(self):
            raise IndexError(
                f"{self.path} has no episode {number}: it has {len(self)}, counted from 0"
            )
        try:
            episode = self._read_episode(number)
        except FAULTS as error:
            raise RecordingError(
                f"episode {number} of {self.path} cannot be read: {error}"
            ) from None
        if not _is_whole(episode):
            raise RecordingError(
                f"episode {number} of {self.path} is damaged: its arrays aren't those of one "
                "episode"
            )
        return episode

    def _read_episode(self, number: int) -> Episode:
        """Returns an episode. Raises one of FAULTS if an array is missing or damaged."""
        folder = f"{_folder_of(number % len(self))}/"
        names = [
            name.removesuffix(".npy") for name in sorted(self._names) if name.startswith(folder)
        ]
        with zipfile.ZipFile(self.path) as file:
            arrays = read_arrays(file, names, LARGEST)
        arrays = {name.removeprefix(folder): array for name, array in arrays.items()}
        for index, name in enumerate(self.header.arrays):
            if array_digest(arrays[name]) != self._digests[number][index].tobytes():
                raise ValueError(f"its {name} are not those that were written")
        events = {
            name.removeprefix("events/"): arrays.pop(name)
            for name in list(arrays)
            if name.startswith("events/")
        }
        return Episode(
            seed=int(arrays.pop("seed")),
            observations=arrays.pop("observations", None),
            events=events,
            terminated=bool(arrays.pop("terminated")),
            truncated=bool(arrays.pop("truncated")),
            **arrays,
        )

    def _check_members(self, summaries: Mapping[str, np.ndarray]) -> None:
        """Raises RecordingError if the arrays of the file aren't those that its header names."""
        of_episodes = (
            f"{_folder_of(number)}/{name}"
            for number in range(len(self))
            for name in self.header.arrays
        )
        if self._names != {f"{name}.npy" for name in (HEADER, *summaries, *of_episodes)}:
            raise RecordingError(
                f"{self.path} is damaged: its arrays are not those that its header names"
            )
        shape = (len(self), len(self.header.arrays), DIGEST_SIZE)
        if self._digests.shape != shape or self._digests.dtype != np.uint8:
            raise RecordingError(
                f"{self.path} is damaged: it doesn't hold the digests of {len(self)} episodes"
            )
        for name, array in summaries.items():
            if array_digest(array).hex() != self.header.digests.get(name):
                raise RecordingError(
                    f"{self.path} is damaged: its returns or digests are not those that were "
                    "written"
                )

    def recording(self, number: int) -> Recording:
        """Returns an episode as a recording that can be replayed."""
        recording = self[number].recording(self.header.environment, self.header.hash)
        if recording.why is None:
            return recording
        players = [self.header.policy] * len(recording.returns)
        return recording.model_copy(update={"players": players})


def _folder_of(number: int) -> str:
    """Returns the folder of an episode in the file."""
    return f"episode_{number:05d}"


def _is_whole(episode: Episode) -> bool:
    """Returns whether the arrays of an episode have consistent shapes and valid dtypes."""
    actions = episode.actions
    rewards = episode.rewards
    observations = episode.observations
    if actions.ndim != 2 or actions.dtype.kind != "i":
        return False
    if rewards.shape != actions.shape or rewards.dtype.kind != "f":
        return False
    num_steps, num_agents = actions.shape
    if observations is not None:
        if observations.ndim != 5 or observations.shape[:2] != (num_steps + 1, num_agents):
            return False
        if observations.dtype != np.uint8:
            return False
    if episode.why is not None and (
        episode.why.shape != actions.shape or episode.why.dtype.kind != "U"
    ):
        return False
    return all(
        count.shape in ((num_steps, num_agents), (num_steps,)) and count.dtype.kind in "iu"
        for count in episode.events.values()
    )


def load_recording(path: Path, episode: int = 0) -> Recording:
    """Returns an episode of a file that `sjdsl play --record` or `sjdsl record` wrote, or of the
    folder of an experiment in which models played.

    Args:
      episode: its number in the file, from 0.

    Raises:
      RecordingError: there is no such file or episode, or the file holds something else.
      ModelError: a file of calls is damaged.
    """
    if path.is_dir():
        recording = asked_recording(path, episode)
    elif path.is_file() and zipfile.is_zipfile(path):
        try:
            recording = Dataset(path).recording(episode)
        except IndexError as error:
            raise RecordingError(str(error)) from None
    else:
        recording = read_recording(path)
        if episode != 0:
            raise RecordingError(f"{path} has no episode {episode}: it has only one, number 0")
    try:
        Arguments.model_validate(recording.environment)
    except ValidationError as error:
        first = error.errors()[0]
        location = ".".join(map(str, ("environment", *first["loc"])))
        raise RecordingError(
            f"{path} has an invalid description of its game: {location}: {first['msg']}"
        ) from None
    return recording
