"""Recorded episodes that can be replayed: stored as seed and actions, or as arrays for offline learning."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names
from sjdsl.replay.dataset import Dataset, DatasetWriter, Header, load_recording
from sjdsl.replay.episode import Episode
from sjdsl.replay.recording import Recording, RecordingError, save_recording

if TYPE_CHECKING:
    from sjdsl.render.moment import Moment
    from sjdsl.replay.episode_player import EpisodePlayer, replayed
    from sjdsl.replay.episodes import play_episodes

__all__ = [
    "Dataset",
    "DatasetWriter",
    "Episode",
    "EpisodePlayer",
    "Header",
    "Moment",
    "Recording",
    "RecordingError",
    "load_recording",
    "play_episodes",
    "replayed",
    "save_recording",
]

__getattr__ = lazy_names(
    __name__,
    {"EpisodePlayer": "episode_player", "Moment": "episode_player", "replayed": "episode_player", "play_episodes": "episodes"},
)
