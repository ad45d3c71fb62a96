"""MuJoCo, run in its own environment: reads one job as JSON, prints one JSON line per run.

A chain of rigid pieces. Joint k, at the middle of cell k, bends for its cell: hinges for torsion
and bending, slides for stretch and shear where they are free, with the stiffness and damping of
the law over the length of the cell. So the chain is of second order in the number of pieces. Large
steps need stretch and shear to be left out of slender rods: an error of a few (r/L)², and of the
strain. Internal moments are generalised forces on the hinges; a tendon is a spatial tendon through
a site of every piece under a constant force.
"""

import json
import os
import resource
import sys
import tempfile
import time

os.chdir(tempfile.gettempdir())  # MuJoCo writes a log of its warnings where it runs
import mujoco  # noqa: E402
import numpy as np  # noqa: E402

AXES = {
    "stretch": ("slide", "1 0 0"), "shear_y": ("slide", "0 1 0"), "shear_z": ("slide", "0 0 1"),
    "torsion": ("hinge", "1 0 0"), "bend_y": ("hinge", "0 1 0"), "bend_z": ("hinge", "0 0 1"),
}  # fmt: skip


def law(case):
    """Return strain → (stiffness, damping) of a cross-section."""
    area, second = np.pi * case["radius"] ** 2, np.pi / 4 * case["radius"] ** 4
    young, shear, eta = case["young"], case["shear"], case["viscosity"]
    bend, cross = (young * second, 3 * eta * second), (shear * area, eta * area)
    return {
        "stretch": (young * area, 3 * eta * area), "shear_y": cross, "shear_z": cross,
        "torsion": (2 * shear * second, 2 * eta * second), "bend_y": bend, "bend_z": bend,
    }  # fmt: skip


def site(case, name, s, at):
    """Return the site of a tendon at arc length s, on a piece whose frame is at ``at``."""
    start, end = (np.array(case["tendon"][key]) for key in ("start", "end"))
    y, z = start + (end - start) * s / case["length"]
    return f'<site name="{name}" pos="{s - at:.17g} {y:.17g} {z:.17g}"/>'


def document(case, settings):
    """Return the model as MJCF."""
    n, length = settings["elements"], case["length"]
    dl = length / n
    line = case["density"] * np.pi * case["radius"] ** 2
    turning = case["density"] * np.pi / 4 * case["radius"] ** 4
    strains, values = settings["strains"], law(case)
    lines, sites = [], []
    first = f'<body pos="0 0 0">{inertial(line, turning, 0.5 * dl)}'
    if case["hinge"]:
        axis = "0 1 0" if case["hinge"] == "y" else "0 0 1"
        first += f'<joint name="hinge" type="hinge" axis="{axis}"/>'
    lines.append(first)
    if case["tendon"]:
        lines.append(site(case, "at0", 0.0, 0.0))
        sites.append("at0")
    for k in range(n):
        at, size = (k + 0.5) * dl, dl if k < n - 1 else 0.5 * dl
        lines.append(f'<body pos="{(0.5 if k == 0 else 1.0) * dl:.17g} 0 0">')
        lines.append(inertial(line, turning, size))
        # hinges in series favour an order of rotations; in turn, forwards and back, they do not
        for strain in strains if k % 2 else reversed(strains):
            kind, axis = AXES[strain]
            stiffness, damping = values[strain]
            lines.append(
                f'<joint name="{strain}{k}" type="{kind}" axis="{axis}" '
                f'stiffness="{stiffness / dl:.17g}" damping="{damping / dl:.17g}"/>'
            )
        if case["tendon"]:
            s = at + 0.5 * dl
            lines.append(site(case, f"at{k + 1}", s, at))
            sites.append(f"at{k + 1}")
    lines.append(f'<site name="tip" pos="{0.5 * dl:.17g} 0 0"/>')
    lines.append("</body>" * (n + 1))
    rope = ""
    if case["tendon"]:
        path = "".join(f'<site site="{name}"/>' for name in sites)
        rope = f'<tendon><spatial name="rope">{path}</spatial></tendon>'
        rope += '<actuator><motor name="pull" tendon="rope" gear="1"/></actuator>'
    gravity = " ".join(f"{g:.17g}" for g in case["gravity"])
    return (
        f'<mujoco><compiler angle="radian" inertiafromgeom="false"/><option gravity="{gravity}" '
        f'timestep="{settings["h"]:.17g}" integrator="{settings["integrator"]}">'
        '<flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{''.join(lines)}</worldbody>{rope}</mujoco>"
    )


def inertial(line, turning, size):
    """Return the inertia of a piece that begins at its frame."""
    across = size * (turning + line * size**2 / 12)
    return (
        f'<inertial pos="{0.5 * size:.17g} 0 0" mass="{line * size:.17g}" '
        f'diaginertia="{2 * turning * size:.17g} {across:.17g} {across:.17g}"/>'
    )


class Chain:
    """A model, its data, and what acts on it over time."""

    def __init__(self, case, settings):
        self.case, self.n = case, settings["elements"]
        self.model = mujoco.MjModel.from_xml_string(document(case, settings))
        self.data = mujoco.MjData(self.model)
        for strain, value in zip(("torsion", "bend_y", "bend_z"), case["offset"], strict=False):
            if value:
                for k in range(self.n):
                    joint = self.model.joint(f"{strain}{k}").qposadr[0]
                    self.data.qpos[joint] = value * case["length"] / self.n
        if case["tendon"]:
            self.data.ctrl[0] = -case["tendon"]["tension"]
        self.shares = self._shares() if case["moments"] else None
        mujoco.mj_forward(self.model, self.data)

    def _shares(self):
        """Return (channels, dofs): which part of its cell a section's moment takes."""
        case, dl = self.case, self.case["length"] / self.n
        ends = np.concatenate([[0.0], np.cumsum(case["sections"])])
        out = np.zeros((len(case["moments"]["channels"]), self.model.nv))
        for c, (section, strain) in enumerate(case["moments"]["channels"]):
            for k in range(self.n):
                low, high = max(k * dl, ends[section]), min((k + 1) * dl, ends[section + 1])
                dof = self.model.joint(f"{strain}{k}").dofadr[0]
                out[c, dof] = max(high - low, 0.0) / dl
        return out

    def advance(self, steps, h):
        """Make steps; torques of the hub change with every one, moments at their period."""
        model, data, case = self.model, self.data, self.case
        if case["hub"]:
            hub = case["hub"]
            for _ in range(steps):
                t = data.time + 0.5 * h
                factor = min(t / hub["ramp"], (hub["end"] - t) / hub["ramp"], 1.0)
                data.qfrc_applied[0] = hub["value"] * max(factor, 0.0)
                mujoco.mj_step(model, data)
        elif case["moments"]:
            held, left = case["moments"], steps
            while left:
                row = int(data.time / held["period"] + 1e-6)
                until = round(((row + 1) * held["period"] - data.time) / h)
                row = min(row, len(held["values"]) - 1)
                data.qfrc_applied[:] = np.array(held["values"][row]) @ self.shares
                go = min(until, left)
                mujoco.mj_step(model, data, nstep=go)
                left -= go
        else:
            mujoco.mj_step(model, data, nstep=steps)

    def tip(self):
        """Return the place of the tip (3,) in m."""
        mujoco.mj_kinematics(self.model, self.data)
        return self.data.site("tip").xpos.copy()


def once(case, settings, outputs):
    """Run; return (tip (outputs, 3), wall s, CPU s, coordinates)."""
    chain = Chain(case, settings)
    tip, per_output, h = np.zeros((outputs, 3)), settings["steps"], settings["h"]
    begin, begin_cpu = time.perf_counter(), time.process_time()
    for k in range(outputs):
        chain.advance(per_output, h)
        tip[k] = chain.tip()
        lost = any(warning.number for warning in chain.data.warning)  # it begins anew by itself
        if lost or not np.isfinite(tip[k]).all() or np.abs(tip[k]).max() > 3 * case["length"]:
            return tip[:k], time.perf_counter() - begin, 0.0, chain.model.nv
    spent = time.process_time() - begin_cpu
    return tip, time.perf_counter() - begin, spent, chain.model.nv


def run(case, settings, limit):
    """Run one setting; the cost is the best of up to five runs within two seconds."""
    period = case["duration"] / case["outputs"]
    strains = settings.get("strains", case["strains"])
    settings = settings | {
        "h": period / settings["steps"],
        "strains": strains,
    }
    _, _, each, coordinates = once(case, settings, 1)
    out = {"coordinates": coordinates, "steps": settings["steps"] * case["outputs"], "tip": []}
    if each * case["outputs"] > limit:
        expected = each * case["outputs"]
        out["reason"] = f"about {expected:.0f} s: over the limit of {limit:g} s"
        return out | {"outcome": "skipped", "wall_s": expected}
    walls, cpus = [], []
    while True:
        tip, wall, cpu, _ = once(case, settings, case["outputs"])
        if len(tip) < case["outputs"]:
            reason = f"not finite or out of reach at {(len(tip) + 1) * period:.3f} s"
            return out | {"outcome": "diverged", "wall_s": wall, "reason": reason}
        walls.append(wall)
        cpus.append(cpu)
        if len(walls) == 5 or sum(walls) > 2.0:
            costs = {"wall_s": min(walls), "cpu_s": min(cpus)}
            return out | costs | {"outcome": "completed", "tip": tip.tolist()}


def main():
    """Read the job, print a line per run."""
    job = json.load(sys.stdin)
    resource.setrlimit(resource.RLIMIT_CPU, (job["everything"], job["everything"]))
    for settings in job["settings"]:
        result = run(job["case"], settings, job["limit"])
        print(json.dumps(result | {"settings": settings}), flush=True)


if __name__ == "__main__":
    main()
