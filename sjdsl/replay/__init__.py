"""Episodes that can be played again: one step at a time, kept in a small file, shown anywhere."""

from sjdsl.replay.course import Course, Moment, replayed
from sjdsl.replay.recording import Recording, RecordingError, load_recording, save_recording

__all__ = ["Course", "Moment", "Recording", "RecordingError", "load_recording", "replayed", "save_recording"]
