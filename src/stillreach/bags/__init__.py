"""Bags of ROS 2: folders with an MCAP file and metadata.yaml, written in whole chunks of ticks."""
