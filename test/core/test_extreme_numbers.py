"""Any number anywhere in a scene: it moves and stays finite, or is refused in words, by its key."""

import json
import re
import time

import numpy as np
import pytest
import yaml
from every_key import DOCUMENTS
from scenes import rod_document, scene_of

from soft_sim_ros.core.accuracy.contract import settle
from soft_sim_ros.core.backend.copying import arrays_of
from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.core.integrators.tableaus import method_of
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SceneError, SolverError
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.scene.reader import Reader

DIGITS = "9" * 450
# what is a number nowhere
NEVER = ["true", "text", "'1'", ".nan", "null", "[]", "{}"]
SOMETIMES = ["0", "-0.0", "1e-320", "1e-300", "1e-160", "1e-70", "1e-30", "1e-12", "-1", "1e5",
             "1e10", "1e16", "1e29", "1e80", "1e155", "1.7e308", "-1e308", ".inf", "-.inf", DIGITS,
             "0." + 400 * "0" + "1"]  # fmt: skip
FORMULAS = ["1/s", "log(s)", "s**-1", "1e308*10", DIGITS, "1e300**s", "0/0", "exp(1000*s)", "-s",
            "s-s", "sin(1/s)", 60 * "(" + "s" + 60 * ")", "9**9**9**9", "s*1e-320", "1e-320",
            "1e160", "True", "1j", "s.__class__", "lambda: 0", "", "10**10**10", "tan(pi/2)",
            "1e-70",
            "1e80*s + 1e-9", 100 * "-" + "s", "s if s else s"]  # fmt: skip
LONGEST = 10.0  # s of this process


def places(tree, path=()):
    """Give the path of every number in a tree."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
        if isinstance(value, (dict, list)):
            yield from places(value, (*path, key))
        elif isinstance(value, (int, float)):
            yield (*path, key)


def at(tree, path):
    for key in path:
        tree = tree[key]
    return tree


def key_path(path):
    return re.sub(r"\.\[", "[", ".".join(f"[{k}]" if isinstance(k, int) else k for k in path))


def written(tree, path, text):
    """Return a scene's YAML with ``text`` as it stands in the place of a number."""
    mark = "@@@"

    def copied(part, ahead):
        if not ahead:
            return mark
        items = part.items() if isinstance(part, dict) else enumerate(part)
        new = {k: copied(v, ahead[1:]) if k == ahead[0] else v for k, v in items}
        return new if isinstance(part, dict) else list(new.values())

    return json.dumps(copied(tree, path)).replace(f'"{mark}"', text)


def judged(text, place, steps):
    """Load a scene and make some steps; return "ok" or the error, one in words that names a key."""
    begin = time.process_time()
    try:
        scene = parse_scene(text, "extreme.yaml")
        if steps:
            simulation = Simulation(scene, prune=False)  # in space, so that all share kernels
            simulation.advance(steps)
            numbers = (simulation.sampler(4).poses(), simulation.ledger(), simulation.v)
        else:
            compiled = compile_scene(settle(scene))
            method_of(compiled.scene)
            numbers = [a for a in arrays_of((compiled.model, compiled.loads._replace(schedule=0)))]
        assert all(np.isfinite(x).all() for x in numbers), f"{place}: not finite"
        outcome = "ok"
    except SceneError as error:
        assert error.file == "extreme.yaml" and error.key_path and error.expected, place
        assert len(str(error)) < 1000
        outcome = error
    except SolverError as error:
        assert steps and str(error), place
        outcome = error
    assert time.process_time() - begin < LONGEST, place
    return outcome


def spread(choices, name, place, count):
    """Return some of the choices: others for every place, the same at every call."""
    begin = sum(map(ord, name + key_path(place)))
    return [choices[(begin + 5 * k) % len(choices)] for k in range(count)]


def test_the_documents_say_every_key(monkeypatch):
    known, said = set(), set()
    only = Reader.only

    def noted(self, *keys):
        known.update(keys)
        said.update(self.keys())
        return only(self, *keys)

    monkeypatch.setattr(Reader, "only", noted)
    for name, document in DOCUMENTS.items():
        parse_scene(yaml.safe_dump(document), name)
    names = {k for k in known if "/" in k or len(k) == 1} | {"one", "two", "column"}
    # a file, a switch, what takes simulations to choose, and more of what others say too
    assert known - said - names == {"file", "rotary_inertia", "tolerance", "shear_y", "shear_z"}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_what_is_a_number_nowhere_is_refused_where_it_stands(name):
    for place in places(DOCUMENTS[name]):
        for text in spread(NEVER, name, place, 1):
            outcome = judged(written(DOCUMENTS[name], place, text), (place, text), 0)
            assert isinstance(outcome, SceneError), (place, text)
            if text not in ("null", "[]", "{}"):
                assert outcome.key_path == key_path(place), text


@pytest.mark.parametrize("name", DOCUMENTS)
def test_numbers_of_any_size_make_a_model_or_an_error(name):
    for place in places(DOCUMENTS[name]):
        for text in spread(SOMETIMES, name, place, 1):
            judged(written(DOCUMENTS[name], place, text), (place, text), 0)


@pytest.mark.parametrize(
    "name", ["tendons", "given", "laws", "maxwell", "free", "curve", "string", "wet"]
)
def test_numbers_of_any_size_make_a_motion_or_an_error(name):
    document = DOCUMENTS[name]
    for place in list(places(document))[sum(map(ord, name)) % 3 :: 3]:
        value = at(document, place)
        near = [repr(value * factor) for factor in (1e-8, 1e-3, 1e3, 1e8, -1)]
        for text in spread([*near, "1e-30", "1e16", "1e29"], name, place, 1):
            judged(written(document, place, text), (place, text), 3)


@pytest.mark.parametrize(
    "place",
    [("cross_section", "radius"), ("reference", "curvature", 0), ("stiffness", "bend_y"),
     ("damping", "bend_z"), ("inertia_per_length", 0), ("coupling", "torsion", "bend_y")],
    ids=key_path,
)  # fmt: skip
def test_formulas_are_numbers_all_along_or_refused_by_their_key(place):
    whole = ("bodies", 0, "sections", 0, *place)
    refused = 0
    for formula in FORMULAS:
        text = written(DOCUMENTS["given"], whole, f"{{expression: '{formula}'}}")
        outcome = judged(text, formula, 0)
        if isinstance(outcome, SceneError) and outcome.key_path.startswith(key_path(whole)):
            refused += 1
    assert refused >= len(FORMULAS) - 8  # a few of them are formulas


# The instances that this began with, by the rule they break.


@pytest.mark.parametrize(
    "schedule",
    [(0.1, 0.3, 0.1), (0.1, 0.7, 0.3), (1e6 + 0.1, 1e6 + 0.3, 0.1), (0.3, 0.9, 0.3)],
)
def test_ramps_that_meet_are_not_refused_for_round_off(schedule):
    document = rod_document(strains=["bend_y"], order=1)
    start, end, ramp = schedule
    load = {"point": "p", "body": "rod", "force": [0, 0, 0.1], "schedule": {}}
    load["schedule"] = {"start": start, "end": end, "ramp": ramp}
    scene = parse_scene(yaml.safe_dump(document | {"loads": [load]}))
    assert scene.loads[0].schedule.factor(0.5 * (start + end)) == pytest.approx(1.0, rel=1e-6)
    load["schedule"]["ramp"] = ramp * 1.001
    with pytest.raises(SceneError, match="ramp"):
        parse_scene(yaml.safe_dump(document | {"loads": [load]}))


@pytest.mark.parametrize("step", ["1e300", "1e10", "1.1e6", "1e-10", ".inf", DIGITS])
def test_a_step_that_time_cannot_count_is_refused(step):
    with pytest.raises(SceneError, match=r"numerics.step"):
        parse_scene(f"bodies: [{{joint: j, kind: free}}]\nnumerics: {{step: {step}}}")


@pytest.mark.parametrize("step", ["1e-9", "0.002", "0.1", "12345.678901234", "1e5"])
def test_a_whole_number_of_nanoseconds_is_a_step_of_any_length(step):
    scene = parse_scene(f"bodies: [{{joint: j, kind: free}}]\nnumerics: {{step: {step}}}")
    assert scene.numerics.step == float(step)


POINTS = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.3, 0.0, 0.0]]


@pytest.mark.parametrize(
    "points",
    [[], POINTS[:3], [*POINTS[:3], POINTS[2]], [POINTS[0], *POINTS], [*POINTS[:3], [1e308, 0, 0]],
     [[-1e308, 0, 0], *POINTS[1:]], [*POINTS[:3], [0.3, float("inf"), 0]], [[0.0], [0.1], [0.2]],
     [*POINTS[:3], [1e30, 0, 0]], [POINTS[0], POINTS[1], POINTS[0], POINTS[1]]],
    ids=repr,
)  # fmt: skip
def test_points_that_no_section_can_follow_are_refused(points):
    section = {"length": 0.3, "reference": {"centre_line": {"points": points}}}
    document = rod_document(strains=["bend_y"], order=1, section=section)
    text = yaml.safe_dump(document)
    with pytest.raises(SceneError, match=r"centre_line\.points"):
        parse_scene(text)


@pytest.mark.parametrize("offset", [1e308, -1e308, 1e31, 1e155])
@pytest.mark.parametrize("where", ["offset", "helix", "points"])
def test_a_tendon_beyond_all_sizes_is_refused(offset, where):
    path = {"offset": [offset, 0.0], "helix": {"radius": abs(offset), "turns": 0.2}}
    path["points"] = [[0.0, 0.01, 0.0], [0.6, offset, 0.0]]
    tendon = {"tendon": "t", "rod": "rod", where: path[where]}
    document = rod_document(strains=["bend_y"], order=1, actuators=[tendon])
    with pytest.raises(SceneError, match=rf"actuators\[0\]\.{where}"):
        parse_scene(yaml.safe_dump(document))


@pytest.mark.parametrize(("elements", "order"), [(10000, 50), (200, 50), (10000, 5)])
def test_more_coordinates_than_anybody_waits_for_are_refused_at_once(elements, order):
    start = time.process_time()
    with pytest.raises(SceneError, match=r"numerics\.rods\.rod = .*order.*fewer elements"):
        compile_scene(scene_of(rod_document(elements=elements, order=order)))
    assert time.process_time() - start < 2.0
