"""Exudyn, run in its own environment: reads one job as JSON, prints one JSON line per run.

Three models, all with the law of the cases:

ge2d : geometrically exact elements in a plane; a locked shear strain is a stiffness 10⁴ times as
    large
ancf : cable elements in a plane: no shear, no rotary inertia, cubic positions
rigid : in space, rigid pieces with spring-dampers of the intrinsic formulation between their ends;
    the first joint has half a piece to bend for. Exudyn's own geometrically exact element in space
    ignores its damping matrix without a word

Internal moments that are constant along a section are offsets of these springs: a joint
bends by M·dl/(EI) more at rest. Couples at the ends of sections would be something else:
the internal moment belongs to the section's frame, so M × κ acts along it.
"""

import itertools
import json
import os
import resource
import sys
import time

import exudyn as exu
import numpy as np
from exudyn.utilities import (
    CoordinateConstraint,
    CreateSymbolicUserFunction,
    Gravity,
    MarkerBodyMass,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    MarkerNodeRigid,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    NodeRigidBodyRotVecLG,
    ObjectANCFCable2D,
    ObjectBeamGeometricallyExact2D,
    ObjectRigidBody,
    RigidBodySpringDamper,
    SensorBody,
    SensorNode,
    Torque,
)  # fmt: skip

exu.config.suppressWarnings = True
esym = exu.symbolic
LOCKED = 1e4  # times the stiffness of a strain that is free


def helix(case, s):
    """Return positions (3,) and rotation vectors (3,) of a rod of uniform strain at s (N,)."""
    kappa = np.array(case["offset"][:3])
    size = np.linalg.norm(kappa)
    hat = np.array([
        [0, -kappa[2], kappa[1]], [kappa[2], 0, -kappa[0]], [-kappa[1], kappa[0], 0],
    ])  # fmt: skip
    for x in s:
        shift = x * np.eye(3)
        if size > 0.0:
            shift += (1 - np.cos(size * x)) / size**2 * hat
            shift += (size * x - np.sin(size * x)) / size**3 * hat @ hat
        yield shift[:, 0], kappa * x


def law(case):
    """Return stiffness and damping (6,) in Exudyn's order: stretch, shears, torsion, bendings."""
    area, second = np.pi * case["radius"] ** 2, np.pi / 4 * case["radius"] ** 4
    young, shear, eta = case["young"], case["shear"], case["viscosity"]
    stiffness = [young * area, shear * area, shear * area, 2 * shear * second]
    damping = [3 * eta * area, eta * area, eta * area, 2 * eta * second]
    stiffness, damping = stiffness + [young * second] * 2, damping + [3 * eta * second] * 2
    return np.array(stiffness), np.array(damping)


def planar(case):
    """Whether the motion lies in a plane through x."""
    return not (case["moments"] or case["tendon"] or any(case["offset"]))


def side(case):
    """Return the direction (3,) that spans the plane of the motion together with x."""
    across = np.array([0.0, *case["gravity"][1:]])
    size = np.linalg.norm(across)
    return across / size if size > 0.0 else np.array([0.0, 1.0, 0.0])


def in_plane(case, settings, mbs):
    """Fill a system with planar elements; return the node of the tip."""
    n, dl = settings["elements"], case["length"] / settings["elements"]
    stiffness, damping = law(case)
    line = case["density"] * np.pi * case["radius"] ** 2
    turning = case["density"] * np.pi / 4 * case["radius"] ** 4
    cable = settings["model"] == "ancf"
    common = {"length": dl, "massPerLength": line}
    common |= {"bendingStiffness": stiffness[5], "axialStiffness": stiffness[0]}
    common |= {"bendingDamping": damping[5], "axialDamping": damping[0]}
    nodes, beams = [], []
    for k in range(n + 1):
        if cable:
            nodes.append(mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[k * dl, 0, 1, 0])))
        else:
            nodes.append(mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[k * dl, 0, 0])))
    free = "shear_y" in case["strains"] or "shear_z" in case["strains"]
    for pair in itertools.pairwise(nodes):
        if cable:
            item = ObjectANCFCable2D(
                nodeNumbers=list(pair), **common,
                useReducedOrderIntegration=settings.get("reduced", 1),
            )  # fmt: skip
        else:
            item = ObjectBeamGeometricallyExact2D(
                nodeNumbers=list(pair), crossSectionInertia=turning,
                shearStiffness=stiffness[1] * (1.0 if free else LOCKED),
                shearDamping=damping[1], **common,
            )  # fmt: skip
        beams.append(mbs.AddObject(item))
    gravity = np.array(case["gravity"])
    pull = [gravity[0], float(gravity @ side(case)), 0]
    if any(pull):
        for beam in beams:
            weighed = mbs.AddMarker(MarkerBodyMass(bodyNumber=beam))
            mbs.AddLoad(Gravity(markerNumber=weighed, loadVector=pull))
    ground = mbs.AddNode(NodePointGround())
    held = (0, 1) if case["hinge"] else (0, 1, 3) if cable else (0, 1, 2)
    for coordinate in held:
        one = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
        two = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[one, two]))
    if case["hub"]:
        hub = case["hub"]
        if cable:
            marker = MarkerBodyRigid(bodyNumber=beams[0], localPosition=[0, 0, 0])
        else:
            marker = MarkerNodeRigid(nodeNumber=nodes[0])
        load = mbs.AddLoad(
            Torque(markerNumber=mbs.AddMarker(marker), loadVector=[0, 0, hub["value"]])
        )

        def torque(mbs, t, vector):
            """Rise, hold, fall; compiled by Exudyn's symbolic functions."""
            rise, fall = t / hub["ramp"], (hub["end"] - t) / hub["ramp"]
            low = esym.IfThenElse(rise < fall, rise, fall)
            low = esym.IfThenElse(low < 1.0, low, esym.Real(1.0))
            return hub["value"] * esym.Vector(
                [0.0, 0.0, esym.IfThenElse(low > 0.0, low, esym.Real(0.0))]
            )

        symbolic = CreateSymbolicUserFunction(mbs, torque, "loadVectorUserFunction", load)
        mbs.SetLoadParameter(load, "loadVectorUserFunction", symbolic)
        mbs.variables["kept"] = symbolic
    return nodes[-1]


def in_space(case, settings, mbs):
    """Fill a system with rigid pieces and springs between them; return the last piece."""
    n, dl = settings["elements"], case["length"] / settings["elements"]
    stiffness, damping = law(case)
    line = case["density"] * np.pi * case["radius"] ** 2
    turning = case["density"] * np.pi / 4 * case["radius"] ** 4
    across = dl * (turning + line * dl**2 / 12)
    last = mbs.AddMarker(MarkerNodeRigid(nodeNumber=mbs.AddNode(NodePointGround())))
    springs, cells = [], []
    for k, (position, turn) in enumerate(helix(case, dl * (np.arange(n) + 0.5))):
        place = np.array([(k + 0.5) * dl, 0.0, 0.0])
        node = mbs.AddNode(
            NodeRigidBodyRotVecLG(
                referenceCoordinates=[*place, 0, 0, 0],
                initialCoordinates=[*(position - place), *turn],
            )
        )
        body = mbs.AddObject(
            ObjectRigidBody(
                nodeNumber=node,
                physicsMass=line * dl,
                physicsInertia=[2 * turning * dl, across, across, 0, 0, 0],
            )
        )
        if any(case["gravity"]):
            heavy = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
            mbs.AddLoad(Gravity(markerNumber=heavy, loadVector=list(case["gravity"])))
        near, far = (
            mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0, 0]))
            for x in (-0.5 * dl, 0.5 * dl)
        )
        cell = (max((k - 0.5) * dl, 0.0), (k + 0.5) * dl)  # what bends in this joint
        share = cell[1] - cell[0]
        springs.append(mbs.AddObject(
            RigidBodySpringDamper(
                markerNumbers=[last, near], stiffness=np.diag(stiffness / share),
                damping=np.diag(damping / share), intrinsicFormulation=True,
            )
        ))  # fmt: skip
        cells.append(cell)
        last = far
    if case["moments"]:
        drive(case, mbs, springs, cells, stiffness)
    return body


def drive(case, mbs, springs, cells, stiffness):
    """Let internal moments act: as offsets of the springs, set anew when they change."""
    held = case["moments"]
    ends = np.concatenate([[0.0], np.cumsum(case["sections"])])
    place = {"torsion": 3, "bend_y": 4, "bend_z": 5}
    shares = np.zeros((len(springs), len(held["channels"]), 6))
    for k, cell in enumerate(cells):
        for c, (section, strain) in enumerate(held["channels"]):
            low, high = max(cell[0], ends[section]), min(cell[1], ends[section + 1])
            axis = place[strain]
            shares[k, c, axis] = max(high - low, 0.0) / stiffness[axis]
    rows = np.array(held["values"])

    def act(efforts):
        for spring, offset in zip(springs, np.einsum("c,kca->ka", efforts, shares), strict=True):
            mbs.SetObjectParameter(spring, "offset", offset)

    act(rows[0])
    if len(rows) == 1:
        return
    now = [(0, 0)]

    def step(mbs, t):
        """Set the efforts of a step that ends at t; Exudyn calls it before the step.

        Generalised-α takes forces at the ends of steps; where one jumps, the mean of both sides
        keeps its second order.
        """
        periods = t / held["period"]
        pair = (int(periods - 1e-6), min(int(periods + 1e-6), len(rows) - 1))
        if pair != now[0]:
            now[0] = pair
            act(0.5 * (rows[pair[0]] + rows[pair[1]]))
        return True

    mbs.SetPreStepUserFunction(step)


def build(case, settings):
    """Return (container, system, sensor of the tip)."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    common = {"storeInternal": True, "outputVariableType": exu.OutputVariableType.Position}
    if settings["model"] == "rigid":
        end = [0.5 * case["length"] / settings["elements"], 0, 0]
        body = in_space(case, settings, mbs)
        sensor = mbs.AddSensor(SensorBody(bodyNumber=body, localPosition=end, **common))
    else:
        sensor = mbs.AddSensor(SensorNode(nodeNumber=in_plane(case, settings, mbs), **common))
    mbs.Assemble()
    return container, mbs, sensor


def solver_settings(case, settings, outputs):
    """Return Exudyn's settings for a run to the given number of outputs."""
    period = case["duration"] / case["outputs"]
    out = exu.SimulationSettings()
    out.solutionSettings.writeSolutionToFile = False
    out.solutionSettings.sensorsWritePeriod = period
    out.timeIntegration.endTime = outputs * period
    out.timeIntegration.numberOfSteps = outputs * settings["steps"]
    out.timeIntegration.verboseMode = 0
    out.timeIntegration.newton.useModifiedNewton = settings.get("modified", True)
    out.timeIntegration.newton.relativeTolerance = settings.get("tolerance", 1e-6)
    out.timeIntegration.generalizedAlpha.spectralRadius = settings["rho"]
    out.timeIntegration.adaptiveStep = False
    if settings["elements"] > 4:
        out.linearSolverType = exu.LinearSolverType.EigenSparse
    out.parallel.numberOfThreads = 1
    return out


def once(case, settings, outputs):
    """Run; return (tip (outputs, 3), wall s, CPU s), or the reason why there is none."""
    _container, mbs, sensor = build(case, settings)  # it must live as long as what it holds
    wanted = solver_settings(case, settings, outputs)
    begin, begin_cpu = time.perf_counter(), time.process_time()
    try:
        done = mbs.SolveDynamic(wanted, showHints=False, showCausingItems=False)
    except Exception as error:
        return str(error).strip().splitlines()[-1]
    wall, cpu = time.perf_counter() - begin, time.process_time() - begin_cpu
    stored = np.array(mbs.GetSensorStoredData(sensor))
    if done is False or len(stored) < outputs + 1:
        return f"its solver stopped at {stored[-1, 0]:.3f} s"
    period = case["duration"] / case["outputs"]
    wanted_times = period * np.arange(1, outputs + 1)
    rows = np.searchsorted(stored[:, 0], wanted_times - 1e-9)
    if np.abs(stored[rows, 0] - wanted_times).max() > 1e-8:
        return "outputs do not fall on steps"
    tip = stored[rows, 1:4]
    if settings["model"] != "rigid":
        tip = np.outer(tip[:, 0], [1.0, 0.0, 0.0]) + np.outer(tip[:, 1], side(case))
    return tip, wall, cpu


def run(case, settings, limit):
    """Run one setting; the cost is the best of up to five runs within two seconds."""
    per = {"ancf": 4, "ge2d": 3, "rigid": 6}[settings["model"]]
    out = {"coordinates": per * (settings["elements"] + (settings["model"] != "rigid"))}
    out |= {"steps": settings["steps"] * case["outputs"], "tip": []}
    first = once(case, settings, 1)
    if isinstance(first, str):
        return out | {"outcome": "diverged", "wall_s": None, "reason": first}
    if first[2] * case["outputs"] > limit:
        expected = first[2] * case["outputs"]
        out["reason"] = f"about {expected:.0f} s: over the limit of {limit:g} s"
        return out | {"outcome": "skipped", "wall_s": expected}
    walls, cpus = [], []
    while True:
        done = once(case, settings, case["outputs"])
        if isinstance(done, str):
            return out | {"outcome": "diverged", "wall_s": None, "reason": done}
        tip, wall, cpu = done
        if not np.isfinite(tip).all() or np.abs(tip).max() > 3 * case["length"]:
            reason = "not finite or out of reach"
            return out | {"outcome": "diverged", "wall_s": wall, "reason": reason}
        walls.append(wall)
        cpus.append(cpu)
        if len(walls) == 5 or sum(walls) > 2.0:
            costs = {"wall_s": min(walls), "cpu_s": min(cpus)}
            return out | costs | {"outcome": "completed", "tip": tip.tolist()}


def main():
    """Read the job, print a line per run."""
    job = json.load(sys.stdin)
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # Exudyn prints why a solver failed, from C++
    resource.setrlimit(resource.RLIMIT_CPU, (job["everything"], job["everything"]))
    for settings in job["settings"]:
        result = run(job["case"], settings, job["limit"])
        print(json.dumps(result | {"settings": settings}), file=answers, flush=True)


if __name__ == "__main__":
    main()
