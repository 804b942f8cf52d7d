"""Episodes that can be played again: one step at a time, kept in a small file, shown anywhere."""

from typing import TYPE_CHECKING, Any

from sjdsl.replay.recording import Recording, RecordingError, load_recording, save_recording

if TYPE_CHECKING:
    from sjdsl.replay.course import Course, Moment, replayed

__all__ = ["Course", "Moment", "Recording", "RecordingError", "load_recording", "replayed", "save_recording"]


def __getattr__(name: str) -> Any:
    """Loads what plays the compiled game when it is first used: a recording can be read and written without JAX."""
    if name not in ("Course", "Moment", "replayed"):
        raise AttributeError(f"module 'sjdsl.replay' has no attribute {name!r}")
    from sjdsl.replay import course

    value = getattr(course, name)
    globals()[name] = value
    return value
