"""The policy of SROS2 allows what the node does in its graph: nothing is missing, nothing more."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from peer import ROOT, simulator, wait_for

SCENE = Path(__file__).with_name("arm.yaml")
POLICY = ROOT / "config" / "sros2" / "policy.xml"


def allowed(kind, what):
    """Full names that the policy's one profile allows, by the rules of SROS2."""
    (profile,) = ElementTree.parse(POLICY).getroot().iter("profile")
    namespace, node = profile.get("ns").rstrip("/"), profile.get("node")
    names = [
        name.text
        for group in profile.findall(f"{kind}s")
        if group.get(what) == "ALLOW"
        for name in group.findall(kind)
    ]
    assert len(names) == len(set(names))
    full = {"/": "", "~": f"{namespace}/{node}"}
    return {
        full[name[0]] + name.removeprefix("~") if name[0] in full else f"{namespace}/{name}"
        for name in names
    }


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    program = simulator(tmp_path_factory.mktemp("arm"), scene=SCENE)
    yield program
    assert program.end() == 0, program.text


def test_the_policy_allows_what_the_node_does_and_nothing_more(arm, peer):
    def found(kind):
        ask = getattr(peer.node, f"get_{kind}_names_and_types_by_node")
        return {name for name, _ in ask("soft_arm", "/")}

    wait_for(lambda: ("soft_arm", "/") in peer.node.get_node_names_and_namespaces(), "the node")
    for kind, policy in (
        ("publisher", allowed("topic", "publish")),
        ("subscriber", allowed("topic", "subscribe")),
        ("service", allowed("service", "reply")),
        ("client", allowed("service", "request")),
    ):
        # the graph arrives in parts
        wait_for(lambda k=kind, p=policy: found(k) >= p, f"{kind}s {sorted(policy - found(kind))}")
        assert found(kind) == policy, kind


def test_the_policy_denies_what_it_does_not_allow():
    root = ElementTree.parse(POLICY).getroot()
    assert (root.tag, root.get("version")) == ("policy", "0.2.0")
    (enclave,) = root.iter("enclave")
    assert enclave.get("path") == "/soft_arm"
    for name in [*root.iter("topic"), *root.iter("service")]:
        assert "*" not in name.text, "a pattern allows more than it says"
    assert not list(root.iter("actions"))


def test_the_policy_is_installed_with_the_package():
    text = (ROOT / "setup.py").read_text()
    assert 'config/sros2", ["config/sros2/policy.xml"]' in text
