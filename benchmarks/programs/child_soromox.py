"""SoRoMoX, run in its own environment: reads one job as JSON, prints one JSON line per run.

Equal physics without additions: its isotropic law is the case's law. Internal moments and the hub's
torque are generalised forces of its ``environment_model``; tendons are its own. Every roll-out is
compiled and warmed up on a short horizon first, which also tells whether the run fits the limit.
One compiled roll-out serves all steps and tolerances of a model and a solver. Semi-implicit Euler
runs at shares of its largest stable step, which is searched for.
"""

import json
import resource
import sys
import time
from pathlib import Path

import jax

jax.config.update("jax_enable_x64", True)
# compiled programs are kept between runs: compiling is not what is timed
jax.config.update("jax_compilation_cache_dir", str(Path(sys.executable).parents[1] / "compiled"))

import diffrax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from soromox.actuation import LinearThreadlikeRoutingParams, ThreadlikeActuator  # noqa: E402
from soromox.simulation import SemiImplicitEuler  # noqa: E402
from soromox.systems import (  # noqa: E402
    GVS,
    PCS,
    PCSStructure,
    PlanarPCS,
    SystemState,
)
from soromox.systems.components import JointSpec, LinkSpec  # noqa: E402
from soromox.systems.gvs import GVSSegment, StrainBasisSpec  # noqa: E402

GENTLE = 0.95  # of the largest step that was stable in a short run
STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
UPRIGHT = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]  # quaternion x y z w, then the position


def tendons(case, segments):
    """Return the case's tendon as an actuator: offset = intercept + slope · s."""
    if not case["tendon"]:
        return {}
    start, end = (np.array([0.0, *case["tendon"][key]]) for key in ("start", "end"))
    routing = LinearThreadlikeRoutingParams(
        intercept=start[None], slope=((end - start) / case["length"])[None],
        start_segment_index=(0,), end_segment_index=(segments - 1,),
    )  # fmt: skip
    return {"actuators": ThreadlikeActuator.tendons(routing)}


def build(case, settings):
    """Return (robot, first coordinate by (segment, strain), lengths, segments per section)."""
    split = settings.get("split", 1)
    lengths = [length / split for length in case["sections"] for _ in range(split)]
    common = {
        "radius": case["radius"], "density": case["density"], "young_modulus": case["young"],
        "shear_modulus": case["shear"], "material_damping_coefficient": case["viscosity"],
    }  # fmt: skip
    locked = ("shear_y", "shear_z") if settings.get("lock_shear") else ()
    kept = settings.get("strains", case["strains"])
    free = [strain in kept and strain not in locked for strain in STRAINS]
    gravity = jnp.array(case["gravity"])
    index, at = {}, 0
    if settings["model"] == "planar_pcs":
        links = [
            LinkSpec.circular(length=x, reference_strain=[0.0, 1.0, 0.0], **common)
            for x in lengths
        ]  # fmt: skip
        robot = PlanarPCS.from_links(
            links, gravity=gravity[:2], base_pose=jnp.zeros(3), **tendons(case, len(lengths))
        )
        return robot, index, lengths, split
    straight = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
    links = [LinkSpec.circular(length=x, reference_strain=straight, **common) for x in lengths]
    if settings["model"] == "pcs":
        structure = PCSStructure(strain_selector=jnp.array(free * len(links)))
        robot = PCS.from_links(
            links, structure=structure, gravity=gravity, base_pose=jnp.array(UPRIGHT),
            **tendons(case, len(lengths)),
        )  # fmt: skip
        orders = [0] * 6
    else:
        orders = [settings["order"] if f else 0 for f in free]
        segments = []
        for k, link in enumerate(links):
            hinged = k == 0 and case["hinge"]
            joint = JointSpec.revolute(case["hinge"]) if hinged else JointSpec.fixed()
            basis = StrainBasisSpec("legendre", [int(f) for f in free], orders)
            points = max(5, settings["order"] + 4)
            segments.append(GVSSegment(link, joint, basis, points))
        robot = GVS.from_segments(
            segments, gravity=gravity, base_pose=jnp.array(UPRIGHT), **tendons(case, len(lengths))
        )
        at = 1 if case["hinge"] else 0
    for k in range(len(links)):
        for strain, f, order in zip(STRAINS, free, orders, strict=True):
            if f:
                index[k, strain] = at
                at += order + 1
    assert at == robot.num_coordinates, (at, robot.num_coordinates)
    return robot, index, lengths, split


def forcing(case, index, lengths, split, size):
    """Return environment_model or None: generalised forces of moments and of the hub's torque."""
    if case["moments"]:
        moments = case["moments"]
        table = np.zeros((len(moments["values"]), size))
        for c, (section, strain) in enumerate(moments["channels"]):
            for k in range(section * split, (section + 1) * split):
                # P0 = 1 and the other Legendre polynomials have no mean
                table[:, index[k, strain]] += lengths[k] * np.array(moments["values"])[:, c]
        table, period = jnp.array(table), moments["period"]

        def held(state):
            row = jnp.clip(jnp.floor(state.t / period + 1e-9).astype(int), 0, len(table) - 1)
            return table[row], None

        return held
    if case["hub"]:
        hub = case["hub"]

        def torque(state):
            rise, fall = state.t / hub["ramp"], (hub["end"] - state.t) / hub["ramp"]
            factor = jnp.clip(jnp.minimum(rise, fall), 0.0, 1.0)
            return jnp.zeros(size).at[0].set(hub["value"] * factor), None

        return torque
    return None


def jumps(case):
    """Return times at which the loads are not smooth."""
    if case["moments"] and len(case["moments"]["values"]) > 1:
        period = case["moments"]["period"]
        return period * np.arange(1, len(case["moments"]["values"]))
    if case["hub"]:
        hub = case["hub"]
        return np.array([hub["ramp"], hub["end"] - hub["ramp"], hub["end"]])
    return None


def compiled(case, settings):
    """Return (coordinates, compiled roll-out, tips of coordinates) of one model and solver."""
    robot, index, lengths, split = build(case, settings)
    size = robot.num_coordinates
    environment = forcing(case, index, lengths, split, size)
    q0 = np.zeros(size)
    for (_, strain), at in index.items():
        q0[at] = case["offset"][STRAINS.index(strain)]
    u = jnp.array([case["tendon"]["tension"]]) if case["tendon"] else jnp.zeros(robot.num_actuators)
    state = SystemState(t=0.0, y=jnp.concatenate([jnp.array(q0), jnp.zeros(size)]), u=u)
    solver_name = settings["solver"]
    solver = {
        "semi_implicit_euler": lambda: SemiImplicitEuler(system=robot),
        "tsit5": diffrax.Tsit5,
        "kvaerno3": diffrax.Kvaerno3,
        "kvaerno5": diffrax.Kvaerno5,
    }[solver_name]()
    adaptive = solver_name != "semi_implicit_euler"

    @jax.jit
    def roll(times, accuracy):
        if adaptive:
            controller = diffrax.PIDController(rtol=accuracy, atol=accuracy * 1e-2)
            marks = jumps(case)
            if marks is not None:
                controller = diffrax.ClipStepSizeController(controller, jump_ts=jnp.array(marks))
            step = jnp.minimum(1e-5, times[-1])
        else:
            controller, step = diffrax.ConstantStepSize(), accuracy
        out = robot.rollout_to(
            state, u=u, t1=times[-1], solver_dt=step, save_ts=times, solver=solver,
            stepsize_controller=controller, environment_model=environment, max_steps=None,
        )  # fmt: skip
        return out.y[:, :size]

    def tips(q):
        poses = jax.vmap(lambda x: robot.forward_kinematics(x, robot.length))(q)
        if settings["model"] == "planar_pcs":
            return jnp.stack([poses[:, 1], poses[:, 2], jnp.zeros(len(q))], axis=1)
        return poses[:, :3, 3]

    return size, roll, tips


def stays(case, roll, times, h):
    """Whether the first 3 % of a run stay within reach with step h."""
    y = np.asarray(roll(times * 0.03, h))
    return bool(np.isfinite(y).all() and np.max(np.abs(y)) < 1e3 / case["radius"])


def largest_stable_step(case, roll, times):
    """Search by factors of 2, then of 1.15."""
    h = 0.03 * float(times[-1]) / 20
    while not stays(case, roll, times, h):
        h /= 2.0
        if h < 1e-7:
            raise ArithmeticError("no stable step above 1e-7 s")
    for _ in range(6):
        if not stays(case, roll, times, 1.15 * h):
            break
        h *= 1.15
    return h


def within_reach(case, tip):
    """Whether a tip (outputs, 3) is one that the rod can have."""
    return bool(np.isfinite(tip).all() and np.max(np.abs(tip)) < 3 * case["length"])


def timed(roll, tips, times, accuracy):
    """Return (wall s, CPU s, tip) of the best of up to three runs."""
    wall = cpu = np.inf
    for _ in range(3):
        begin, begin_cpu = time.perf_counter(), time.process_time()
        q = roll(times, accuracy).block_until_ready()
        last = time.perf_counter() - begin
        wall, cpu = min(wall, last), min(cpu, time.process_time() - begin_cpu)
        if last > 1.0:
            break
    return wall, cpu, np.asarray(tips(q))


def run(case, settings, limit, kept):
    """Run one setting; ``kept`` holds the last compiled roll-out and its largest stable step."""
    out = {"tip": []}
    key = json.dumps({k: v for k, v in settings.items() if k not in ("accuracy", "fraction")})
    times = jnp.array(case["duration"] / case["outputs"] * np.arange(1, case["outputs"] + 1))
    try:
        if key not in kept:
            kept.clear()
            begin = time.process_time()
            kept[key] = compiled(case, settings)
            size, roll, tips = kept[key]
            roll(times * 1e-3, settings.get("accuracy", 1e-5)).block_until_ready()
            out["cold_s"] = time.process_time() - begin
        size, roll, tips = kept[key]
        out["coordinates"] = size
        if "fraction" in settings:
            if "step" not in kept:
                kept["step"] = largest_stable_step(case, roll, times)
            accuracy = out["step"] = GENTLE * settings["fraction"] * kept["step"]
        else:
            accuracy = settings["accuracy"]
        spans = []
        for share in (0.01, 0.03):
            begin = time.process_time()
            short = roll(times * share, accuracy).block_until_ready()
            spans.append(time.process_time() - begin)
            if not np.isfinite(short).all():
                out["reason"] = f"not finite within {share * case['duration']:.3f} s"
                return out | {"outcome": "diverged", "wall_s": spans[-1]}
        expected = spans[0] + max(spans[1] - spans[0], 0.0) / 0.02
        if expected > limit:
            out["reason"] = f"about {expected:.0f} s expected: over the limit of {limit:g} s"
            return out | {"outcome": "skipped", "wall_s": expected}
        wall, cpu, tip = timed(roll, tips, times, accuracy)
        for _ in range(3):
            if within_reach(case, tip) or "fraction" not in settings:
                break
            # a short run does not show every instability: a smaller step has its chance
            kept["step"] *= 0.8
            accuracy = out["step"] = GENTLE * settings["fraction"] * kept["step"]
            wall, cpu, tip = timed(roll, tips, times, accuracy)
    except Exception as error:
        out["reason"] = str(error).strip().splitlines()[0][:200]
        return out | {"outcome": "refused", "wall_s": None}
    if not within_reach(case, tip):
        return out | {"outcome": "diverged", "wall_s": wall, "reason": "not finite or out of reach"}
    return out | {"outcome": "completed", "wall_s": wall, "cpu_s": cpu, "tip": tip.tolist()}


def main():
    """Read the job, print a line per run."""
    job = json.load(sys.stdin)
    resource.setrlimit(resource.RLIMIT_CPU, (job["everything"], job["everything"]))
    kept = {}
    for settings in job["settings"]:
        result = run(job["case"], settings, job["limit"], kept)
        print(json.dumps(result | {"settings": settings}), flush=True)


if __name__ == "__main__":
    main()
