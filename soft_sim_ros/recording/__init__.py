"""Bytes and files: CDR messages, rosbag2 recordings, and their way back to numbers."""
