"""Recordings as pages, pictures and tables; no ROS, and matplotlib only when something is drawn."""

from soft_sim_ros.report.export import export_csv, export_npz
from soft_sim_ros.report.page import picture, write_report

__all__ = ["export_csv", "export_npz", "picture", "write_report"]
