"""Exudyn, run in its own environment: two undamped benchmarks of Simo and Vu-Quoc.

Reads {"which", "elements", "steps", "outputs"} as JSON, prints the places of two points.
Geometrically exact elements with two nodes: in the plane for the beam in
free flight, in space for the elbow.
"""

import itertools
import json
import sys

import exudyn as exu
import numpy as np
from exudyn.utilities import (
    Force,
    GenericJoint,
    MarkerNodeRigid,
    NodePointGround,
    NodeRigidBody2D,
    NodeRigidBodyRotVecLG,
    ObjectBeamGeometricallyExact,
    ObjectBeamGeometricallyExact2D,
    SensorNode,
    Torque,
)  # fmt: skip

exu.config.suppressWarnings = True


def flying(mbs, job):
    """Fill a system with the beam; return its loaded and its free end."""
    data, n = job["data"], job["elements"]
    start, end = np.array(data["from"]), np.array(data["to"])
    way = end - start
    length, angle = np.linalg.norm(way), np.arctan2(way[1], way[0])
    nodes = [
        mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[*(start + way * k / n), angle]))
        for k in range(n + 1)
    ]
    for pair in itertools.pairwise(nodes):
        mbs.AddObject(
            ObjectBeamGeometricallyExact2D(
                nodeNumbers=list(pair),
                length=length / n,
                massPerLength=data["line"],
                crossSectionInertia=data["inertia"][2],
                bendingStiffness=data["bend"],
                axialStiffness=data["stretch"],
                shearStiffness=data["shear"],
                includeReferenceRotations=True,
            )
        )
    held = mbs.AddMarker(MarkerNodeRigid(nodeNumber=nodes[0]))

    def shape(t):
        """Be one, then none; at the jump the mean, which keeps generalised-α's second order."""
        return 0.5 - 0.5 * np.sign(np.round(t - data["until"], 9))

    mbs.AddLoad(Force(
        markerNumber=held, loadVector=[data["force"], 0, 0],
        loadVectorUserFunction=lambda mbs, t, load: shape(t) * np.array(load),
    ))  # fmt: skip
    mbs.AddLoad(Torque(
        markerNumber=held, loadVector=[0, 0, data["moment"]],
        loadVectorUserFunction=lambda mbs, t, load: shape(t) * np.array(load),
    ))  # fmt: skip
    return nodes[0], nodes[-1]


def elbow(mbs, job):
    """Fill a system with both legs; return the corner and the tip."""
    data, n = job["data"], job["elements"]
    section = exu.BeamSection()
    section.stiffnessMatrix = np.diag(
        [data["stretch"], data["shear"], data["shear"], data["torsion"], data["bend"], data["bend"]]
    )
    section.inertia, section.massPerLength = np.diag(data["inertia"]), data["line"]
    last = mbs.AddMarker(MarkerNodeRigid(nodeNumber=mbs.AddNode(NodePointGround())))
    place, ends = np.zeros(3), []
    for way, turn in (((1, 0, 0), [0, 0, 0]), ((0, 1, 0), [0, 0, np.pi / 2])):
        step = data["leg"] / n * np.array(way)
        nodes = [
            mbs.AddNode(NodeRigidBodyRotVecLG(referenceCoordinates=[*(place + k * step), *turn]))
            for k in range(n + 1)
        ]
        for pair in itertools.pairwise(nodes):
            mbs.AddObject(
                ObjectBeamGeometricallyExact(
                    nodeNumbers=list(pair), length=data["leg"] / n, sectionData=section
                )
            )
        near, far = (mbs.AddMarker(MarkerNodeRigid(nodeNumber=nodes[k])) for k in (0, -1))
        unturn = np.eye(3) if not turn[2] else np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
        mbs.AddObject(GenericJoint(markerNumbers=[last, near], rotationMarker1=unturn))
        place, last = place + n * step, far
        ends.append((nodes[-1], far))

    def load(mbs, t, vector):
        """Rise to the peak and fall again."""
        rise = data["until"] / 2
        return max(0.0, min(t / rise, 2.0 - t / rise)) * np.array(vector)

    mbs.AddLoad(Force(
        markerNumber=ends[0][1], loadVector=[0, 0, data["force"]], loadVectorUserFunction=load
    ))  # fmt: skip
    return ends[0][0], ends[1][0]


def main():
    """Run one job, print places (outputs + 1, 2, 3)."""
    job = json.load(sys.stdin)
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    nodes = {"flying": flying, "elbow": elbow}[job["which"]](mbs, job)
    kind = {"storeInternal": True, "outputVariableType": exu.OutputVariableType.Position}
    sensors = [mbs.AddSensor(SensorNode(nodeNumber=node, **kind)) for node in nodes]
    mbs.Assemble()
    wanted = exu.SimulationSettings()
    wanted.solutionSettings.writeSolutionToFile = False
    wanted.solutionSettings.sensorsWritePeriod = job["duration"] / job["outputs"]
    wanted.timeIntegration.endTime = job["duration"]
    wanted.timeIntegration.numberOfSteps = job["outputs"] * job["steps"]
    wanted.timeIntegration.newton.useModifiedNewton = job.get("modified", True)
    wanted.timeIntegration.newton.relativeTolerance = job.get("tolerance", 1e-8)
    wanted.timeIntegration.generalizedAlpha.spectralRadius = job.get("rho", 0.95)
    wanted.timeIntegration.verboseMode = 0
    wanted.linearSolverType = exu.LinearSolverType.EigenSparse
    wanted.parallel.numberOfThreads = 1
    mbs.SolveDynamic(wanted, showHints=False)
    times = np.linspace(0.0, job["duration"], job["outputs"] + 1)
    places = []
    for sensor in sensors:
        stored = np.array(mbs.GetSensorStoredData(sensor))
        rows = np.minimum(np.searchsorted(stored[:, 0], times - 1e-9), len(stored) - 1)
        if np.abs(stored[rows, 0] - times).max() > 1e-8:
            raise RuntimeError("outputs do not fall on steps")
        places.append(stored[rows, 1:4].tolist())
    print(json.dumps(np.array(places).transpose(1, 0, 2).tolist()))


if __name__ == "__main__":
    main()
