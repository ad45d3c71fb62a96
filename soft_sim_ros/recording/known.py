"""Which channels of a recording carry our topics."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.foreign import printable
from soft_sim_ros.recording import topics
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.scene.words import NAME


def find_known(
    path: Path, channels: Sequence[Channel], node: str | None, others: Collection[int] = ()
) -> dict[str, int]:
    """Map the keys of our topics to the channels that carry them.

    Parameters
    ----------
    path : of the recording
    channels : of the recording
    node : full name of the node; None: the only one
    others : channels that are known to carry something else

    Raises
    ------
    RecordingError
        if there are several arms, or none
    """
    known: dict[str, int] = {}
    for key, (name, kind, _) in topics.ALL.items():
        own = [
            index
            for index, channel in enumerate(channels)
            if channel.type == kind and index not in others
        ]
        wanted = None if node is None else topics.resolve(name, node)
        last = name.rpartition("/")[2]
        limbs = _limbs(channels, own, last, wanted) if key in topics.LIMBS else {}
        members = {index for found in limbs.values() for index in found.values()}
        alone = [
            index
            for index in own
            if key not in topics.NAMED
            and index not in members
            and _last(channels[index].topic) == last
            and wanted in (None, channels[index].topic)
        ]
        if len(alone) > 1 or len(limbs.keys() | {channels[index].topic for index in alone}) > 1:
            fitting = sorted([*alone, *members])
            named = ", ".join(printable(channels[index].topic) for index in fitting[:8])
            raise RecordingError(path, f"holds several arms ({named}): say which with node=…")
        known |= {key: alone[0]} if alone else {}
        for found in limbs.values():
            known |= {f"{key}/{limb}": index for limb, index in found.items()}
    if channels and not known:
        held = ", ".join(f"{printable(f'{c.topic} ({c.type})')}" for c in channels[:8])
        expected = ", ".join(name for name, *_ in topics.ALL.values())
        of = "" if node is None else f" of {node}"
        raise RecordingError(path, f"holds none of the topics {expected}{of}; it holds {held}")
    return known


def _limbs(
    channels: Sequence[Channel], own: Sequence[int], last: str, wanted: str | None
) -> dict[str, dict[str, int]]:
    """Return the channels that carry one limb each, by the topic above them and by the limb."""
    found: dict[str, dict[str, int]] = {}
    for index in own:
        above, _, limb = channels[index].topic.rpartition("/")
        if _last(above) == last and wanted in (None, above) and NAME.fullmatch(limb):
            found.setdefault(above, {})[limb] = index
    # a node may have the name of a topic: /backbone/backbone alone is what the node /backbone says
    return {above: limbs for above, limbs in found.items() if wanted or set(limbs) != {last}}


def _last(topic: str) -> str:
    return topic.rpartition("/")[2]
