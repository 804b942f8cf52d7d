"""Recorded episodes for replays, as seed and actions, or for offline learning, as arrays."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from sjdsl.render.moment import Moment as Moment
    from sjdsl.replay.dataset import Dataset as Dataset
    from sjdsl.replay.dataset import DatasetWriter as DatasetWriter
    from sjdsl.replay.dataset import Header as Header
    from sjdsl.replay.dataset import load_recording as load_recording
    from sjdsl.replay.episode import Episode as Episode
    from sjdsl.replay.episode_player import EpisodePlayer as EpisodePlayer
    from sjdsl.replay.episode_player import replayed as replayed
    from sjdsl.replay.episodes import play_asked_episodes as play_asked_episodes
    from sjdsl.replay.episodes import play_episodes as play_episodes
    from sjdsl.replay.recording import Recording as Recording
    from sjdsl.replay.recording import RecordingError as RecordingError
    from sjdsl.replay.recording import save_recording as save_recording

__getattr__ = lazy_names(
    __name__,
    {
        "dataset": ("Dataset", "DatasetWriter", "Header", "load_recording"),
        "episode": ("Episode",),
        "episode_player": ("EpisodePlayer", "Moment", "replayed"),
        "episodes": ("play_asked_episodes", "play_episodes"),
        "recording": ("Recording", "RecordingError", "save_recording"),
    },
)
