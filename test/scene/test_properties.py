"""Random scenes are read back as they were written; random damage is always a SceneError."""

import copy
import json
import math
import re

import pytest
import yaml
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import STRAINS, Joint, RigidBody, Rod, parse_scene

# Shrinking a random scene takes minutes; a failure is better reported as it came.
QUICK = settings(
    deadline=None,
    phases=(Phase.explicit, Phase.reuse, Phase.generate),
    suppress_health_check=[HealthCheck.too_slow],
)

positive = st.floats(1e-3, 1e3)
signed = st.floats(-1e3, 1e3)
vectors = st.lists(signed, min_size=3, max_size=3)
small = st.floats(1e-3, 1.0)
tapers = st.one_of(small, st.lists(small, min_size=2, max_size=2))
shapes = st.one_of(
    st.fixed_dictionaries({"shape": st.just("circle"), "radius": tapers}),
    st.fixed_dictionaries(
        {"shape": st.just("annulus"), "outer": st.floats(0.5, 1), "inner": st.floats(0.1, 0.4)}
    ),
    st.fixed_dictionaries({"shape": st.just("rectangle"), "width_y": tapers, "width_z": tapers}),
    st.fixed_dictionaries(
        {"shape": st.just("ellipse"), "semi_axis_y": tapers, "semi_axis_z": tapers}
    ),
)
materials = st.fixed_dictionaries(
    {
        "young_modulus": st.floats(1e3, 1e12),
        "poisson_ratio": st.floats(0, 0.5),
        "density": st.floats(1, 1e5),
    },
    optional={"viscosity": st.floats(0, 1e6), "axial_viscosity": st.floats(0, 1e6)},
)
poses = st.fixed_dictionaries({}, optional={"position": vectors, "rpy": vectors})


sections = st.fixed_dictionaries(
    {"length": positive, "material": st.just("stuff"), "cross_section": shapes},
    optional={
        "reference": st.fixed_dictionaries({}, optional={"curvature": vectors}),
        "shear_correction": small,
    },
)
section_lists = st.lists(sections, min_size=1, max_size=3)
strain_lists = st.lists(st.sampled_from(STRAINS), min_size=1, unique=True)


@st.composite
def rods(draw, name):
    parts = [{"name": f"part{i}", **part} for i, part in enumerate(draw(section_lists))]
    return {"rod": name, "strains": draw(strain_lists), "sections": parts}


@st.composite
def joints(draw, name):
    joint = {"joint": name, "offset": draw(poses)}
    if draw(st.booleans()):
        return {**joint, "kind": "fixed"}
    axis = draw(vectors.filter(lambda v: math.hypot(*v) > 1e-3))
    return {**joint, "kind": "revolute", "axis": axis, "damping": draw(positive)}


def rigid_bodies(name):
    return st.fixed_dictionaries(
        {"rigid_body": st.just(name), "mass": positive}, optional={"com": poses}
    )


@st.composite
def drives_and_loads(draw, bodies):
    actuators, loads = [], []
    for body in bodies:
        name = next(iter(body.values()))
        if body.get("kind") == "revolute":
            low, high = sorted(draw(st.tuples(signed, signed)))
            limits = {"limits": [low, high], "safe": low}
            actuators.append({"joint_torque": f"drive_{name}", "joint": name, **limits})
        if "rod" not in body:
            continue
        section, strain = body["sections"][-1]["name"], body["strains"][0]
        moment = {"moment": f"bend_{name}", "rod": name, "section": section, "strain": strain}
        cable = {"tendon": f"cable_{name}", "rod": name, "offset": [draw(small), draw(small)]}
        actuators += [moment, cable]
        end = draw(st.floats(0.1, 0.9)) * sum(s["length"] for s in body["sections"])
        schedule = {"start": draw(signed), "ramp": draw(small)}
        loads.append({"point": f"push_{name}", "body": name, "s": end, "force": draw(vectors)})
        wind = {"distributed": f"wind_{name}", "body": name, "end": end, "moment": draw(vectors)}
        loads.append({**wind, "schedule": schedule})
    return {"actuators": actuators, "loads": loads}


@st.composite
def scenes(draw):
    makers = draw(st.lists(st.sampled_from([rods, joints, rigid_bodies]), min_size=1, max_size=4))
    bodies = [draw(maker(f"body{i}")) for i, maker in enumerate(makers)]
    return {
        "name": "random",
        "gravity": draw(vectors),
        "base": draw(poses),
        "materials": {"stuff": draw(materials)},
        "bodies": bodies,
        **draw(drives_and_loads(bodies)),
        "numerics": {
            "step": draw(st.integers(1, 10**7)) * 1e-9,
            "basis": {"order": draw(st.integers(0, 9)), "elements": draw(st.integers(1, 9))},
        },
    }


def read(tree):
    # JSON is YAML, and written faster.
    return parse_scene(json.dumps(tree), "random.yaml")


@given(scenes())
@settings(QUICK, max_examples=60)
def test_what_was_written_is_what_is_read(tree):
    scene = parse_scene(yaml.safe_dump(tree, sort_keys=False), "random.yaml")
    assert scene.gravity.tolist() == tree["gravity"]
    assert scene.numerics.step == tree["numerics"]["step"]
    kinds = {Rod: "rod", Joint: "joint", RigidBody: "rigid_body"}
    for body, written in zip(scene.bodies, tree["bodies"], strict=True):
        assert body.name == written[kinds[type(body)]]
        if isinstance(body, Rod):
            assert set(body.strains) == set(written["strains"])
            for section, source in zip(body.sections, written["sections"], strict=True):
                assert section.length == source["length"]
                assert section.material.young_modulus == tree["materials"]["stuff"]["young_modulus"]
                shape = source["cross_section"]
                for key in set(shape) - {"shape"}:
                    taper = getattr(section.cross_section, key)
                    ends = shape[key] if isinstance(shape[key], list) else [shape[key]] * 2
                    assert [taper.start, taper.end] == ends
            assert scene.numerics.rods[body.name].order == dict.fromkeys(
                body.strains, tree["numerics"]["basis"]["order"]
            )
        elif isinstance(body, RigidBody):
            assert body.mass == written["mass"]
        else:
            assert body.kind == written["kind"]
    for actuator, written in zip(scene.actuators, tree["actuators"], strict=True):
        assert actuator.name == next(iter(written.values()))
        assert actuator.limits[0] <= actuator.safe <= actuator.limits[1]
        if "limits" in written:
            assert list(actuator.limits) == written["limits"]
    for load, written in zip(scene.loads, tree["loads"], strict=True):
        end = load.s if "point" in written else load.end
        assert end == pytest.approx(written.get("s", written.get("end")), rel=1e-9)
        assert load.force.tolist() == written.get("force", [0, 0, 0])


def places(tree, path=()):
    """Return the path of every key and list entry of a tree."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, (dict, list)):
            found += places(value, (*path, key))
    return found


def value_at(tree, path):
    for key in path:
        tree = tree[key]
    return tree


def key_path(path):
    return re.sub(r"\.\[", "[", ".".join(f"[{k}]" if isinstance(k, int) else k for k in path))


@given(scenes(), st.data(), st.sampled_from([math.nan, True, "many", None, -math.inf, [], "'"]))
@settings(QUICK, max_examples=100)
def test_a_number_that_is_none_is_refused_at_its_place(tree, data, bad):
    def is_number(path):
        # A lower limit may be -.inf.
        return isinstance(value_at(tree, path), (int, float)) and "limits" not in path

    path = data.draw(st.sampled_from([path for path in places(tree) if is_number(path)]))
    value_at(tree, path[:-1])[path[-1]] = bad
    with pytest.raises(SceneError) as caught:
        read(tree)
    assert caught.value.key_path == key_path(path)


@given(scenes(), st.data())
@settings(QUICK, max_examples=100)
def test_a_misspelt_key_is_refused_by_its_name(tree, data):
    keys = [path for path in places(tree) if isinstance(path[-1], str) and path[-1] != "stuff"]
    path = data.draw(st.sampled_from(keys))
    place = data.draw(st.integers(0, len(path[-1])))
    wrong = path[-1][:place] + "q" + path[-1][place:]
    parent = value_at(tree, path[:-1])
    items = [(wrong if key == path[-1] else key, value) for key, value in parent.items()]
    parent.clear()
    parent.update(items)
    with pytest.raises(SceneError) as caught:
        read(tree)
    # A misspelt word that says what an entry is may be reported for the entry as a whole.
    assert caught.value.key_path in (key_path((*path[:-1], wrong)), key_path(path[:-1]))


anything = st.recursive(
    st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(scenes(), st.data(), anything)
@settings(QUICK, max_examples=100)
def test_anything_anywhere_is_read_or_refused_but_never_breaks(tree, data, bad):
    path = data.draw(st.sampled_from(places(tree)))
    broken = copy.deepcopy(tree)
    if data.draw(st.booleans()):
        value_at(broken, path[:-1])[path[-1]] = bad
    else:
        del value_at(broken, path[:-1])[path[-1]]
    assume(broken != tree)
    try:
        read(broken)
    except SceneError as error:
        assert error.file == "random.yaml"
        assert error.expected


@given(scenes(), st.data())
@settings(QUICK, max_examples=100)
def test_scribbled_text_is_read_or_refused_but_never_breaks(tree, data):
    text = yaml.safe_dump(tree, default_flow_style=None)
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 20)))
    text = (
        text[:start]
        + data.draw(st.text("[]{}:,-#&*!|>'\"%@`\n\t ~.e01xé\x00", max_size=4))
        + text[end:]
    )
    try:
        parse_scene(text, "random.yaml")
    except SceneError as error:
        assert error.file == "random.yaml"
