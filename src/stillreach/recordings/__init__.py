"""Recordings of a robot, by joint name: rosbag2, MCAP, CSV, Parquet, LeRobot datasets and runs."""

from stillreach.recordings.recording import Recording

__all__ = ["Recording"]
