"""One entry of ``sections`` of a rod, read and checked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from soft_sim_ros.scene.cross_section import read_cross_section
from soft_sim_ros.scene.features import cuts
from soft_sim_ros.scene.given import GIVEN, read_given
from soft_sim_ros.scene.interval import POSITIVE
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.profile import CHECKED
from soft_sim_ros.scene.read_fluid import read_rod_fluid
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.reference import read_reference
from soft_sim_ros.scene.rod_model import RodModel
from soft_sim_ros.scene.sampling import Unresolved
from soft_sim_ros.scene.section import Section
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.taper import Floats


def read_section(
    reader: Reader,
    materials: dict[str, Material],
    model: RodModel,
    strains: tuple[str, ...],
    taken: set[str],
) -> Section:
    """Read one entry of ``sections`` of a rod of a model with some active strains."""
    reader.only(
        "name",
        "length",
        "material",
        "cross_section",
        "reference",
        "shear_correction",
        "fluid",
        *GIVEN,
    )
    length = reader.number("length", POSITIVE)
    section = Section(
        name=reader.name("name", taken=taken),
        length=length,
        material=materials[reader.reference("material", materials, "material")],
        cross_section=read_cross_section(reader.mapping("cross_section", required=True), length),
        reference=read_reference(reader.mapping("reference"), length),
        shear_correction=_read_shear_correction(reader),
        model=model,
        given=read_given(reader, length),
        fluid=read_rod_fluid(reader),
    )
    if model.is_limp and section.material.law is not None:
        what = f"a material without a law: a {model.name} has no bending stiffness"
        reader.refuse(what, "material")
    for key in ("stiffness", "coupling"):
        if section.material.law is not None:
            reader.no_effect(key, "the law of the material says how stiff it is")
    if model.is_limp:
        reader.no_effect("coupling", f"a {model.name} has no bending stiffness")
    _check_representable(reader, section, strains)
    try:
        return replace(section, cuts=cuts(section))
    except Unresolved as error:
        reader.refuse(str(error))


def _read_shear_correction(reader: Reader) -> tuple[float, float] | None:
    if not reader.has("shear_correction"):
        return None
    if reader.is_list("shear_correction"):
        ky, kz = reader.vector("shear_correction", 2, POSITIVE)
        return float(ky), float(kz)
    factor = reader.number("shear_correction", POSITIVE)
    return factor, factor


def _check_representable(reader: Reader, section: Section, strains: tuple[str, ...]) -> None:
    """Refuse stiffnesses and inertias that vanish or overflow in floating-point numbers."""
    with np.errstate(all="ignore"):
        places = np.union1d(CHECKED, section.knots)
        stiffness, inertia = section.stiffness(places), section.inertia(places)
    for name in (strain for strain in strains if strain not in section.model.limp):
        for value in stiffness[:, STRAINS.index(name)]:
            if not (value > np.finfo(float).tiny and np.isfinite(value)):
                # Cowper's factor of a flat ellipse turns negative for auxetic materials.
                hint = " (give shear_correction)" if name.startswith("shear") else ""
                expected = f"a {name} stiffness > 0 and finite, it is {value:g}{hint}"
                reader.refuse(expected, "cross_section")
    _check_coupling(reader, section, strains, places)
    tilt, turn = section.model.rotary
    inertia = inertia[:, [True, turn, tilt, tilt]]
    if not (np.all(inertia > np.finfo(float).tiny) and np.all(np.isfinite(inertia))):
        reader.refuse("a mass and inertia per length > 0 and finite", "cross_section")


def _check_coupling(
    reader: Reader, section: Section, strains: tuple[str, ...], places: Floats
) -> None:
    """Refuse couplings with which some combination of active strains would not resist."""
    if not section.given.coupling:
        return
    own = [STRAINS.index(strain) for strain in strains]
    size = 1.0 / np.sqrt(section.stiffness(places)[:, own])
    whole = section.laws(places)[0][:, own][:, :, own] * size[:, :, None] * size[:, None, :]
    least = np.linalg.eigvalsh(whole)[:, 0]
    if least.min() <= 1e-12:
        where = f"it is not at s = {places[least.argmin()] * section.length:g} m"
        reader.refuse(f"a stiffness matrix that is positive definite ({where})", "coupling")
