"""What of the arm is for eyes and for tf: told of each state after it has been sent."""

from __future__ import annotations

from collections.abc import Callable

from soft_sim_ros.node.markers import Markers
from soft_sim_ros.node.parameters import Settings
from soft_sim_ros.node.publishers import Matched
from soft_sim_ros.node.tip_frame import ArmFrames
from soft_sim_ros.scene import Scene


def views_of(
    node, scene: Scene, settings: Settings, paused: Callable[[], bool], matched: Matched
) -> list[Markers | ArmFrames]:
    """Return the views that the parameters ask for; they show nothing before ``show``."""
    views: list[Markers | ArmFrames] = []
    if settings.publish_tf:
        along = settings.poses if settings.tf_backbone else 0
        views.append(ArmFrames(node, scene, settings.frame_id, settings.tf_frames, along, matched))
    if settings.marker_rate:
        views.append(Markers(node, settings.frame_id, settings.marker_rate, paused, matched))
    return views
