"""Quality of service: ROS profiles of ours, and which overrides of them a user may give."""

from __future__ import annotations

import difflib
from collections.abc import Collection

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from soft_sim_ros.foreign import shown
from soft_sim_ros.node.parameters import ALIKE, QOS, ParameterError
from soft_sim_ros.recording.topics import Qos

_DEEPEST = 1_000_000
_WORDS = {
    QoSPolicyKind.RELIABILITY: ReliabilityPolicy,
    QoSPolicyKind.HISTORY: HistoryPolicy,
    QoSPolicyKind.DURABILITY: DurabilityPolicy,
}
# What a user may choose per topic, as parameters qos_overrides.<topic>.publisher.<policy>.
_POLICIES = (*_WORDS, QoSPolicyKind.DEPTH)
OVERRIDABLE = QoSOverridingOptions(policy_kinds=_POLICIES)


def qos_profile(qos: Qos) -> QoSProfile:
    """ROS profile of a recorded or planned quality of service."""
    return QoSProfile(
        depth=qos.depth,
        history=HistoryPolicy[qos.history.upper()],
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )


def check_overrides(
    node, published: list[str], subscribed: list[str], shared: Collection[str] = ()
) -> list[str]:
    """Refuse overrides of topics and policies that the node does not offer, and unusable values.

    Parameters
    ----------
    node : rclpy.node.Node
        What is asked.
    published, subscribed : list of str
        Topics as they are given to ROS, before they are remapped.
    shared : collection of str
        Parameters from entries for nodes of any name.

    Returns
    -------
    list of str
        Those of them that are for other nodes.

    Raises
    ------
    ParameterError
        With all that is wrong; ROS itself would stop at the first fault, without a name.
    """
    known = {
        f"{QOS}{node.resolve_topic_name(topic)}.{kind}.{policy.name.lower()}": policy
        for kind, topics in (("publisher", published), ("subscription", subscribed))
        for topic in topics
        for policy in _POLICIES
    }
    faults, others = [], []
    for name, parameter in node._parameter_overrides.items():
        if not name.startswith(QOS):
            continue
        if name not in known and name in shared and _of_others(name, known):
            others.append(name)
        elif name not in known:
            near = difflib.get_close_matches(name[:200], list(known), n=1, cutoff=0.0)
            hint = f"; the nearest known one is {near[0]!r}" if near else ""
            faults.append(f"unknown parameter {shown(name, 200)}{hint}")
        elif not _fits(known[name], parameter.value):
            expected = _expected(known[name])
            faults.append(f"{name} = {shown(parameter.value)}: expected {expected}")
    if faults:
        raise ParameterError(faults)
    return others


def _of_others(name: str, known: Collection[str]) -> bool:
    """Whether an override is for a topic, or an end of one, that only other nodes have."""
    topic, kind, _ = _parts(name)
    if kind not in ("publisher", "subscription"):
        return False
    space, _, last = topic.rpartition("/")
    for other in known:
        own, own_kind, _ = _parts(other)
        own_space, _, own_last = own.rpartition("/")
        if topic == own and kind == own_kind:
            return False  # the policy is wrong
        if topic != own and space == own_space and _alike(last, own_last):
            return False  # the topic is misspelt
    return True


def _parts(name: str) -> tuple[str, str, str]:
    """Split the name of an override into topic, kind and policy."""
    rest, _, policy = name.removeprefix(QOS).rpartition(".")
    topic, _, kind = rest.rpartition(".")
    return topic, kind, policy


def _alike(one: str, other: str) -> bool:
    return bool(difflib.get_close_matches(one[:200], [other], n=1, cutoff=ALIKE))


def _choices(policy: QoSPolicyKind) -> list[str]:
    words = _WORDS[policy].__members__
    return [w.lower() for w in words if w != "UNKNOWN" and not w.startswith("RMW")]


def _fits(policy: QoSPolicyKind, value: object) -> bool:
    if policy in _WORDS:
        return isinstance(value, str) and value.lower() in _choices(policy)
    return type(value) is int and 1 <= value <= _DEEPEST


def _expected(policy: QoSPolicyKind) -> str:
    if policy in _WORDS:
        return f"one of {', '.join(_choices(policy))}"
    return f"a whole number from 1 to {_DEEPEST}"
