"""Recordings of a robot: read from other tools' files, by joint name, and written by a loop of one's own."""

from stillreach.recordings.recorder import Recorder
from stillreach.recordings.recording import Recording

__all__ = ["Recorder", "Recording"]
