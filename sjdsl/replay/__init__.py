"""Episodes that can be played again: one step at a time or many at once, kept in files, shown anywhere."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sjdsl.replay.dataset import Dataset, DatasetWriter, Header
from sjdsl.replay.episode import Episode
from sjdsl.replay.files import load_recording
from sjdsl.replay.recording import Recording, RecordingError, save_recording

if TYPE_CHECKING:
    from sjdsl.replay.course import Course, Moment, replayed
    from sjdsl.replay.episodes import play_episodes

__all__ = [
    "Course",
    "Dataset",
    "DatasetWriter",
    "Episode",
    "Header",
    "Moment",
    "Recording",
    "RecordingError",
    "load_recording",
    "play_episodes",
    "replayed",
    "save_recording",
]

LATER = {"Course": "course", "Moment": "course", "replayed": "course", "play_episodes": "episodes"}


def __getattr__(name: str) -> Any:
    """Loads what plays the compiled game when it is first used: recordings can be read and written without JAX."""
    if name not in LATER:
        raise AttributeError(f"module 'sjdsl.replay' has no attribute {name!r}")
    value = getattr(import_module(f"sjdsl.replay.{LATER[name]}"), name)
    globals()[name] = value
    return value
