"""Classical models of a rod as choices of active strains, stiffnesses and rotary inertia.

Curvilinear Systems 2006, chapter 3: strains that a model forbids are not computed, and the wrench
components that enforce this are reactions.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from soft_sim_ros.scene.strains import STRAINS

BENDING = ("bend_y", "bend_z")


@dataclass(frozen=True)
class RodModel:
    """The strains that a model of a rod allows, and its resistance to them.

    strains : components that can change; the others keep their reference values and the wrench
        components conjugate to them are reactions
    limp : those of them without stiffness and damping
    rotary : whether a section that tilts, and one that turns about the backbone, has inertia
    """

    name: str
    strains: tuple[str, ...]
    limp: tuple[str, ...] = ()
    rotary: tuple[bool, bool] = field(default=(True, True))

    @property
    def is_limp(self) -> bool:
        """Whether the rod has no stiffness of its own in bending: a string or a cable.

        Such a rod cannot hold a direction at its start either; it is hinged there.
        """
        return bool(self.limp)


COSSERAT = RodModel("cosserat", STRAINS)
MODELS = {
    model.name: model
    for model in (
        COSSERAT,
        RodModel("timoshenko", ("torsion", *BENDING, "shear_y", "shear_z")),
        RodModel("kirchhoff", ("torsion", *BENDING, "stretch")),
        RodModel("inextensible", ("torsion", *BENDING)),
        RodModel("euler_bernoulli", ("torsion", *BENDING), rotary=(False, True)),
        RodModel("cable", (*BENDING, "stretch"), BENDING, (False, False)),
        RodModel("string", BENDING, BENDING, (False, False)),
    )
}
