"""Scenes of links in a floating frame."""

import numpy as np

LENGTH, RADIUS, E, RHO = 1.0, 0.01, 2e9, 1000.0
AREA, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
LINE = RHO * AREA  # mass per length
STRIP = {"name": "s", "length": LENGTH, "material": "m",
         "cross_section": {"shape": "circle", "radius": RADIUS}}  # fmt: skip
MATERIAL = {"m": {"young_modulus": E, "shear_modulus": E / 2.6, "density": RHO}}


def link(name="link", strains=("bend_y", "bend_z"), **more):
    return {
        "flexible_link": name, "strains": list(strains), "sections": [STRIP], "modes": 4,
    } | more  # fmt: skip


def document(bodies, **more):
    common = {"name": "links", "gravity": [0, 0, 0], "materials": MATERIAL, "bodies": bodies,
              "numerics": {"step": 0.002}}  # fmt: skip
    return common | more
