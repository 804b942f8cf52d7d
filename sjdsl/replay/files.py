"""Opens a file of recorded episodes, of one or of many."""

from pathlib import Path

from sjdsl.replay.dataset import Dataset, is_dataset
from sjdsl.replay.recording import Recording, RecordingError, read_recording


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
