"""Small scenes that together say every key of a scene: see test_extreme_numbers.py."""

import math
from typing import Any

SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.4, "density": 1000.0, "viscosity": 300.0}
ALL = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]
CIRCLE = {"shape": "circle", "radius": 0.02}
NUMERICS = {
    "step": 0.002,
    "integrator": "sdirk2",
    "newton_tolerance": 1e-8,
    "max_iterations": 20,
    "basis": {"order": 1, "elements": 1, "nodes": 4},
}
ARC = [[0.3 * math.sin(i / 5), 0.3 * (1 - math.cos(i / 5)), 0.0] for i in range(6)]
FRAMES = [[0.0, 0.0, math.sin(i / 10), math.cos(i / 10)] for i in range(6)]


def rod(name: str, *strains: str, **section: Any) -> dict[str, Any]:
    """Return a rod of one section."""
    whole = {"name": "s", "length": 0.3, "material": "soft", "cross_section": CIRCLE} | section
    return {"rod": name, "strains": list(strains) or ["bend_y", "bend_z"], "sections": [whole]}


DOCUMENTS: dict[str, dict[str, Any]] = {}
DOCUMENTS["carried"] = {
    "name": "carried",
    "gravity": [0.1, 0.2, -9.0],
    "materials": {"soft": SOFT},
    "bodies": [
        {
            "joint": "rail",
            "kind": "prismatic",
            "axis": [0.3, 0.5, -0.8],
            "driven": {"table": [[0.0, 0.0], [0.1, 0.02]]},
        },
        rod("one"),
        {
            "rigid_body": "ring",
            "mass": 0.1,
            "parent": {"body": "one", "s": 0.1, "offset": {"position": [0.0, 0.01, 0.0]}},
            "attached": False,
        },
        {
            "joint": "table",
            "kind": "universal",
            "axes": [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            "parent": "base",
            "driven": {"first": {"formula": "0.2*t"}, "second": "sin(t)"},
        },
        rod("two"),
    ],
    "numerics": NUMERICS,
}
DOCUMENTS["held"] = {
    "name": "held",
    "materials": {"soft": SOFT},
    "bodies": [rod("one", *ALL), rod("two", *ALL) | {"parent": "base"}],
    "constraints": [
        {
            "name": "far",
            "kind": "weld",
            "frames": [{"body": "one"}, {"world": {"position": [0.3, 0.0, 0.0]}}],
            "start": 0.0,
            "end": 0.5,
        },
        {
            "name": "rope",
            "kind": "distance",
            "length": 0.1,
            "frames": [
                {"body": "two", "s": 0.2, "offset": {"position": [0.0, 0.0, 0.1]}},
                {"body": "one", "s": 0.2},
            ],
        },
        {
            "name": "pin",
            "kind": "hinge",
            "axis": [0.0, 1.0, 0.0],
            "frames": [{"body": "two"}],
        },
    ],
    "numerics": NUMERICS,
}
DOCUMENTS["chain"] = {
    "name": "chain",
    "gravity": [0.1, 0.2, -9.0],
    "base": {"position": [0.1, 0.2, 0.3], "rpy": [0.1, 0.2, 0.3]},
    "materials": {
        "soft": SOFT | {"axial_viscosity": 500.0, "rayleigh": {"mass": 0.1, "stiffness": 0.001}}
    },
    "bodies": [
        {
            "joint": "hip",
            "kind": "revolute",
            "axis": [0.3, 0.5, -0.8],
            "stiffness": 0.4,
            "damping": 0.02,
            "offset": {"position": [0.0, 0.02, 0.03], "quaternion": [0.0, 0.0, 0.0, 1.0]},
        },
        {
            "rigid_body": "motor",
            "mass": 0.3,
            "inertia": [1e-4, 2e-4, 2.5e-4],
            "com": {"position": [0.01, 0.02, -0.01], "rpy": [0.3, 0.0, 0.5]},
        },
        {
            "rod": "one",
            "strains": ALL,
            "sections": [
                {
                    "name": "a",
                    "length": 0.2,
                    "material": "soft",
                    "cross_section": {
                        "shape": "ellipse",
                        "semi_axis_y": [0.03, 0.025],
                        "semi_axis_z": 0.02,
                    },
                    "reference": {
                        "curvature": [1.0, [0.0, 2.0], -1.0],
                        "stretch": 1.1,
                        "shear": [0.01, 0.02],
                    },
                    "shear_correction": [0.8, 0.9],
                },
                {
                    "name": "b",
                    "length": 0.15,
                    "material": "soft",
                    "cross_section": {"shape": "rectangle", "width_y": 0.04, "width_z": 0.03},
                },
            ],
        },
        {
            "joint": "u",
            "kind": "universal",
            "axes": [[0, 1, 0], [0, 0, 1]],
            "stiffness": 0.1,
            "damping": 0.01,
        },
        {"joint": "p", "kind": "prismatic", "axis": [1, 0, 0], "stiffness": 10.0, "damping": 1.0},
        {"joint": "ball", "kind": "spherical"},
        {
            "rod": "two",
            "strains": ["torsion", "bend_y"],
            "sections": [
                {
                    "name": "c",
                    "length": 0.25,
                    "material": "soft",
                    "cross_section": {"shape": "annulus", "outer": [0.03, 0.02], "inner": 0.01},
                }
            ],
        },
        {"rigid_body": "end", "mass": 0.2, "inertia": [1e-4, 1e-4, 1e-4]},
    ],
    "actuators": [
        {"joint_torque": "h", "joint": "hip", "limits": [-1.0, 1.0], "safe": 0.1},
        {"joint_torque": "u1", "joint": "u", "axis": "second", "safe": 0.01},
        {"joint_force": "f", "joint": "p", "safe": 0.1},
        {
            "moment": "m",
            "rod": "one",
            "section": "a",
            "strain": "bend_y",
            "safe": 0.01,
            "limits": [-1.0, 1.0],
        },
    ],
    "loads": [
        {
            "point": "pt",
            "body": "one",
            "s": 0.1,
            "force": [0.3, -0.4, 0.2],
            "moment": [0.02, 0.05, -0.03],
            "schedule": {"start": 0.001, "end": 0.005, "ramp": 0.001},
        },
        {
            "distributed": "d",
            "body": "two",
            "start": 0.1,
            "end": 0.2,
            "force": [1.0, -2.0, 0.5],
            "moment": [0.1, 0.0, 0.0],
            "frame": "body",
        },
    ],
    "initial": {
        "positions": {"hip": 0.1, "u": [0.1, 0.2], "p": 0.01, "ball": [0.1, 0.2, 0.3]},
        "velocities": {"hip": 1.0, "u": [0.1, 0.2], "p": 0.01, "ball": [1.0, 0.2, 0.3]},
        "strains": {"one/a": {"bend_y": 0.1, "stretch": 0.01}},
    },
    "numerics": NUMERICS,
}
DOCUMENTS["tendons"] = {
    "materials": {"soft": SOFT},
    "gravity": [0, 0, -9.81],
    "bodies": [rod("r", "bend_y", "bend_z", "stretch")],
    "actuators": [
        {
            "tendon": "a",
            "rod": "r",
            "offset": [0.01, 0.0],
            "start": 0.0,
            "end": 0.3,
            "safe": 1.0,
            "limits": [0.0, 50.0],
            "friction": 0.1,
            "slip_speed": 1e-3,
        },
        {
            "tendon": "b",
            "rod": "r",
            "offset": {"from": [0.01, 0.01], "to": [0.0, 0.01]},
            "control": "length",
            "axial_stiffness": 1e4,
            "axial_damping": 10.0,
            "limits": [-0.01, 0.05],
            "safe": 0.001,
        },
        {
            "tendon": "c",
            "rod": "r",
            "helix": {"radius": [0.01, 0.005], "angle": 0.4, "turns": 0.7},
            "safe": 0.5,
        },
        {
            "tendon": "d",
            "rod": "r",
            "helix": {"radius": 0.01, "angle": 0.4, "pitch": 0.5},
            "start": 0.05,
            "end": 0.25,
        },
        {
            "tendon": "e",
            "rod": "r",
            "points": [[0.0, 0.01, 0.0], [0.1, 0.01, 0.005], [0.3, 0.0, 0.01]],
            "safe": 0.1,
        },
        {
            "chamber": "g",
            "rod": "r",
            "offset": [0.0, 0.01],
            "area": 1e-4,
            "safe": 100.0,
            "limits": [0.0, 1e5],
        },
    ],
    "numerics": NUMERICS
    | {
        "basis": {"order": 1, "elements": 1, "nodes": 6},
        "integrator": "generalized_alpha",
        "options": {"rho": 0.6},
    },
}
DOCUMENTS["given"] = {
    "materials": {"soft": SOFT},
    "bodies": [
        {
            "rod": "r",
            "strains": ALL,
            "sections": [
                {
                    "name": "s",
                    "length": 0.3,
                    "material": "soft",
                    "cross_section": {"shape": "circle", "radius": 0.02},
                    "mass_per_length": 1.0,
                    "inertia_per_length": [1e-4, 1e-4, 1e-4],
                    "stiffness": {
                        "bend_y": 0.1,
                        "torsion": {
                            "table": [[0.0, 0.1], [0.1, 0.2], [0.3, 0.1]],
                            "interpolation": "cubic",
                        },
                    },
                    "damping": {"bend_y": 0.01, "bend_z": {"expression": "0.01*(1+s)"}},
                    "coupling": {"torsion": {"bend_y": 0.001}},
                    "reference": {
                        "curvature": [
                            {"expression": "sin(10*s)"},
                            {
                                "table": [[0.0, 0.1], [0.1, 0.2], [0.3, 0.1]],
                                "interpolation": "linear",
                            },
                            0.5,
                        ]
                    },
                }
            ],
        }
    ],
    "numerics": NUMERICS | {"integrator": "adaptive", "options": {"error": 1e-5}},
}
DOCUMENTS["laws"] = {
    "materials": {
        "soft": {
            "density": 1000.0,
            "viscosity": 100.0,
            "law": {"kind": "mooney_rivlin", "c10": 1e5, "c01": 2e4},
        },
        "yeoh": {"density": 1000.0, "law": {"kind": "yeoh", "c10": 1e5, "c20": 1e3, "c30": 10.0}},
        "tab": {
            "density": 1000.0,
            "law": {
                "kind": "table",
                "stretch": [0.5, 1.0, 1.5, 2.0],
                "stress": [-3e5, 0.0, 2e5, 4e5],
            },
        },
    },
    "gravity": [0, 0, -9.81],
    "bodies": [
        rod("r", "bend_y", "stretch"),
        rod("y", "torsion", "bend_y", material="yeoh"),
        rod(
            "t",
            "bend_y",
            material="tab",
            cross_section={"shape": "rectangle", "width_y": 0.03, "width_z": 0.02},
        ),
    ],
    "numerics": NUMERICS,
}
DOCUMENTS["maxwell"] = {
    "materials": {"soft": SOFT | {"maxwell": {"ratio": 0.5, "time": 0.1}}},
    "gravity": [0, 0, -9.81],
    "bodies": [{"joint": "j", "kind": "revolute", "axis": [0, 1, 0], "stiffness": 1.0}, rod("r")],
    "initial": {"state": "equilibrium", "guesses": {"j": 0.1}},
    "numerics": NUMERICS
    | {"basis": {"kind": "chebyshev", "order": {"bend_y": 2, "bend_z": 1}, "elements": 2}},
}
DOCUMENTS["link"] = {
    "materials": {"soft": {"young_modulus": 1e6, "shear_modulus": 4e5, "density": 1000.0}},
    "gravity": [0, 0, -9.81],
    "bodies": [
        {"joint": "j", "kind": "revolute", "axis": [0, 1, 0]},
        {
            "flexible_link": "l",
            "strains": ["bend_y", "bend_z"],
            "modes": {"bend_y": 1, "bend_z": 1},
            "tip": "free",
            "tip_mass": 0.1,
            "sections": [{"name": "s", "length": 0.3, "material": "soft", "cross_section": CIRCLE}],
        },
    ],
    "loads": [{"point": "x", "body": "l", "s": 0.2, "force": [0, 0, 1.0]}],
    "initial": {"positions": {"l": [0.001, 0.001], "j": 0.1}, "velocities": {"l": [0.1, 0.0]}},
    "numerics": NUMERICS | {"integrator": "energy_midpoint"},
}
DOCUMENTS["wet"] = {
    "materials": {"soft": SOFT},
    "gravity": [0.1, 0.2, -9.0],
    "fluid": {
        "density": 1000.0,
        "current": {"x": 0.1, "y": "0.2*t", "z": {"table": [[0.0, 0.0], [0.1, 0.02]]}},
        "drag_normal": 1.1,
        "drag_tangential": 0.01,
        "lift": [0.1, 0.2, 0.3],
        "added_mass": [1.0, 1.2],
        "viscous_normal": 0.3,
        "viscous_tangential": 0.2,
        "drag_law": "whole",
        "flooded": True,
        "surface": 1.0,
    },
    "bodies": [
        rod("r", fluid={"drag_normal": [1.2, 1.3]}) | {"fluid": {"dry_ends": ["end"]}},
        {
            "rigid_body": "ball",
            "mass": 0.1,
            "inertia": [1e-4, 1e-4, 1e-4],
            "fluid": {"radius": 0.02, "drag": 0.5, "viscous": 0.1},
        },
        {
            "rigid_body": "hull",
            "mass": 0.1,
            "fluid": {
                "semi_axes": [0.03, 0.02, 0.01],
                "center": {"position": [0.01, 0.0, 0.0], "rpy": [0.1, 0.2, 0.3]},
                "lift": 0.1,
                "rotary_drag": [0.1, 0.2, 0.3],
                "rotary_viscous": 0.01,
            },
        },
        {
            "rigid_body": "box",
            "mass": 0.1,
            "fluid": {
                "volume": 1e-5,
                "area": [0.01, 0.02, 0.03],
                "added_mass": [0.01, 0.02, 0.03],
                "added_inertia": 1e-5,
            },
        },
    ],
    "numerics": NUMERICS,
}
DOCUMENTS["free"] = {
    "materials": {"soft": SOFT},
    "gravity": [0, 0, 0],
    "bodies": [
        {"joint": "fly", "kind": "free"},
        {"rigid_body": "hub", "mass": 1.0, "inertia": [0.1, 0.1, 0.1]},
        rod("r"),
    ],
    "initial": {
        "positions": {"fly": [0.1, 0.2, 0.3, 0.0, 0.0, 1.0]},
        "velocities": {"fly": [1.0, 2.0, 0.3, 0.0, 0.1, 1.0]},
    },
    "numerics": NUMERICS | {"integrator": "implicit_midpoint"},
}
DOCUMENTS["curve"] = {
    "materials": {"soft": SOFT},
    "bodies": [
        rod("r", length=0.3, reference={"centre_line": {"points": ARC, "normal": [0.0, 0.0, 1.0]}})
    ],
    "numerics": NUMERICS | {"rods": {"r": {"order": 2, "elements": 1, "nodes": 5}}},
}
DOCUMENTS["frames"] = {
    "materials": {"soft": SOFT},
    "bodies": [rod("r", length=0.3, reference={"centre_line": {"points": ARC, "frames": FRAMES}})],
    "numerics": NUMERICS,
}
DOCUMENTS["cable"] = {
    "materials": {"soft": SOFT},
    "gravity": [0, 0, -9.81],
    "bodies": [
        {
            "rod": "c",
            "model": "cable",
            "sections": [{"name": "s", "length": 0.3, "material": "soft", "cross_section": CIRCLE}],
        },
        {"rigid_body": "b", "mass": 0.1},
    ],
    "initial": {"state": "equilibrium"},
    "numerics": {"step": 0.002, "integrator": "sdirk3"},
}
DOCUMENTS["string"] = {
    "materials": {"soft": SOFT},
    "gravity": [0, 0, -9.81],
    "bodies": [
        {
            "rod": "c",
            "model": "string",
            "sections": [{"name": "s", "length": 0.3, "material": "soft", "cross_section": CIRCLE}],
        }
    ],
    "numerics": {"step": 0.002, "integrator": "sdirk4"},
}
LAW = {
    "stiffness": 1e5,
    "onset": 1e-4,
    "dissipation": 0.5,
    "friction": {"static": 0.6, "kinetic": 0.5, "across": 0.4},
    "tangential_stiffness": 2e5,
    "tangential_time": 1e-3,
}
AWAY = {"position": [0.2, 0.1, -0.3]}
LINE = {"from": [0.1, 0.0, -0.4], "to": [0.3, 0.1, -0.4], "radius": 0.05}
DOCUMENTS["touching"] = {
    "materials": {"soft": SOFT, "stone": SOFT | {"young_modulus": 1e9}},
    "gravity": [0, 0, -9.81],
    "contact": {"friction": 0.3},
    "environment": [
        {"plane": "floor", "position": [0.0, 0.0, -0.05], "normal": [0.1, 0.0, 1.0]},
        {"sphere": "post", "radius": 0.1, "contact": LAW} | AWAY,
        {"capsule": "bar", "bodies": ["r", "ball"], "overlap": False} | LINE,
        {"cylinder": "drum", "contact": {"material": "stone"}} | LINE,
        {"box": "step", "size": [0.1, 0.2, 0.1], "rpy": [0.1, 0.2, 0.3]} | AWAY,
        {"ellipsoid": "egg", "semi_axes": [0.1, 0.08, 0.05], "rpy": [0.1, 0.2, 0.3]} | AWAY,
        {"sphere": "room", "radius": 3.0, "inside": True},
    ],
    "bodies": [
        rod("r"),
        {
            "rigid_body": "ball",
            "mass": 0.1,
            "shape": {"kind": "sphere", "radius": 0.03, "position": [0.03, 0.0, 0.0]},
            "contact": {"material": "stone"},
        },
        {
            "rigid_body": "stick",
            "mass": 0.1,
            "shape": {
                "kind": "capsule",
                "from": [0.0, 0.0, 0.0],
                "to": [0.05, 0.0, 0.0],
                "radius": 0.02,
            },
            "contact": LAW,
        },
        {
            "rigid_body": "brick",
            "mass": 0.1,
            "shape": {
                "kind": "box",
                "size": [0.03, 0.02, 0.02],
                "position": [0.02, 0.0, 0.0],
                "rpy": [0.1, 0.0, 0.0],
                "rounding": 0.002,
            },
            "contact": LAW,
        },
    ],
    "numerics": NUMERICS,
}
DOCUMENTS["sensed"] = {
    "materials": {"soft": SOFT},
    "gravity": [0, 0, -9.81],
    "bodies": [
        {"joint": "one", "kind": "revolute", "axis": [0.0, 1.0, 0.0], "stiffness": 1.0},
        rod("r"),
    ],
    "actuators": [{"tendon": "pull", "rod": "r", "offset": [0.0, 0.01]}],
    "sensors": [
        {"strain": "gauge", "rod": "r", "s": 0.1, "offset": [0.0, 0.02], "direction": [1, 0, 0.1]},
        {"curvature": "fibre", "rod": "r", "s": [0.1, 0.2], "noise": 1e-3, "bias": 0.01},
        {
            "imu": "unit",
            "body": "r",
            "s": 0.15,
            "offset": {"position": [0.0, 0.01, 0.0]},
            "noise": {"acceleration": [0.1, 0.1, 0.2], "angular_velocity": 0.1, "orientation": 0.1},
            "rate": 250.0,
            "latency": 0.01,
            "seed": 3,
        },
        {"wrench": "load", "body": "one", "bias": {"torque": 0.1, "force": [0.1, 0.0, 0.0]}},
        {
            "tendon": "cell",
            "actuator": "pull",
            "noise": {"length": 1e-4, "rate": 1e-3, "tension": 0.1},
        },
        {"encoder": "angle", "joint": "one", "noise": {"position": 1e-3, "velocity": 1e-2}},
    ],
    "numerics": NUMERICS,
}
DOCUMENTS["meeting"] = {
    "materials": {"soft": SOFT, "stone": SOFT | {"young_modulus": 1e9}},
    "gravity": [0, 0, -9.81],
    "bodies": [
        rod("r"),
        {"joint": "j", "kind": "prismatic", "axis": [1, 0, 0], "parent": "base"},
        {
            "rigid_body": "ball",
            "mass": 0.1,
            "shape": {"kind": "sphere", "radius": 0.03, "position": [0.03, 0.0, 0.3]},
            "contact": {"material": "stone"},
        },
    ],
    "environment": [{"plane": "top", "position": [0.0, 0.0, -0.5], "on": "j"}],
    "pairs": [
        {"bodies": ["r", "ball"], "contact": {"friction": 0.2}, "overlap": False},
        {"self": ["r"]},
    ],
    "numerics": NUMERICS,
}
