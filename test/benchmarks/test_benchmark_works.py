"""One small case through the machinery of the benchmark: cases, our adapter, errors, fronts."""

import dataclasses
import importlib
import threading

import numpy as np
import pytest


def module(name):
    return importlib.import_module(f"benchmarks.{name}")


def short(name, outputs):
    case = module("cases").CASES[name]
    return dataclasses.replace(case, outputs=outputs, duration=outputs * case.output_period)


def test_every_case_becomes_a_scene_with_all_its_settings():
    ours, settings = module("programs.ours"), module("programs.settings")
    cases = module("cases").CASES
    assert len(cases) >= 8
    for case in cases.values():
        for chosen in settings.ours(case):
            scene = ours.scene_of(case, chosen)
            step_ns = round(scene.numerics.step * 1e9)
            assert ours.steps_in(case.output_period, step_ns) >= 1
            if case.moments:
                assert ours.steps_in(case.moments.period, step_ns) >= 1


@pytest.mark.slow
def test_a_finer_run_is_closer_to_an_independent_formulation():
    ours, absolute = module("programs.ours"), module("independent.absolute")
    distance = module("reference").distance
    case = short("planar_pcs", 4)
    grids = [absolute.Grid(case, n).tip(1e-6) for n in (8, 16)]
    independent = grids[1] + (grids[1] - grids[0]) / 3.0
    errors = []
    for order in (0, 3):
        chosen = {"order": order, "step": 0.01, "integrator": "sdirk3"}
        run = ours.run(case, chosen, repeats=1)
        assert run.outcome == "completed"
        errors.append(distance(run.tip, independent, case.length))
    assert errors[1] < 1e-3
    assert errors[1] < 0.1 * errors[0], errors


def test_held_moments_reach_the_arm_at_their_times():
    ours = module("programs.ours")
    case = short("chirp", 2)
    still = dataclasses.replace(
        case, moments=dataclasses.replace(case.moments, values=((0.0, 0.0),) * 200)
    )
    chosen = {"order": 2, "step": 0.005}
    moved, hung = (ours.run(c, chosen, repeats=1).tip for c in (case, still))
    assert np.all(hung[:, 1:] == 0.0)
    assert np.linalg.norm(moved[-1, 1:]) > 1e-4 * case.length


def test_a_step_that_does_not_divide_the_outputs_is_refused():
    with pytest.raises(ValueError, match="does not divide"):
        module("programs.ours").steps_in(0.05, 3_000_000)


def test_fronts_interpolate_in_logarithms_and_say_what_is_not_reached():
    fronts = module("fronts")
    entries = [
        {"outcome": "completed", "wall_s": wall, "error_rel": error}
        for wall, error in ((1.0, 1e-1), (100.0, 1e-3), (200.0, 1e-2))
    ]
    assert fronts.front(entries) == [(1e-1, 1.0), (1e-3, 100.0)]
    assert fronts.cost_at(entries, 1e-2) == pytest.approx(10.0)
    assert fronts.cost_at(entries, 0.5) == 1.0
    assert fronts.cost_at(entries, 1e-4) is None


def test_what_no_run_reaches_is_extrapolated_by_the_order_of_the_best_runs():
    fronts = module("fronts")

    def runs(*points):
        return [{"outcome": "completed", "wall_s": w, "error_rel": e} for w, e in points]

    second = runs((1.0, 1e-2), (10.0, 1e-3), (100.0, 1e-4))  # cost over one over the error
    assert fronts.beyond(second, 1e-5) == pytest.approx(1000.0)
    assert fronts.beyond(second, 1e-3) is None  # reached
    assert fronts.beyond(second, 1e-7) is None  # too far
    assert fronts.beyond(runs((1.0, 1e-2)), 1e-3) is None  # no order
    assert fronts.beyond(runs((1.0, 1e-3), (1.0001, 2e-4)), 1e-4) is None  # no order one believes


def test_what_a_peer_cannot_do_is_said_with_the_reason():
    peers, cases = module("programs.peers"), module("cases").CASES
    assert "no tendons" in peers.unsupported("pyelastica", cases["tendon_step"])
    assert peers.unsupported("soromox", cases["tendon_step"]) == ""


def test_the_strains_of_a_plane_give_the_motion_of_all_six():
    ours, settings = module("programs.ours"), module("programs.settings")
    distance = module("reference").distance
    for name in settings.PLANES:
        case = short(name, 3)
        chosen = {
            "order": 3, "nodes": 8, "step": case.output_period, "integrator": "adaptive",
            "options": {"error": 1e-8},
        }  # fmt: skip
        planar = ours.run(case, chosen | settings.plane_of(case), repeats=1)
        spatial = ours.run(case, chosen, repeats=1)
        assert planar.coordinates < spatial.coordinates
        assert np.ptp(spatial.tip, axis=0).max() > 1e-3 * case.length
        assert distance(planar.tip, spatial.tip, case.length) < 1e-6


def test_every_job_runs_once_and_peers_never_share_a_core(tmp_path, monkeypatch):
    schedule = module("schedule")
    monkeypatch.setattr(schedule, "FILE", tmp_path / "costs.json")
    monkeypatch.setattr(schedule, "pin", lambda core: None)
    jobs = [
        schedule.Job(program, case)
        for program in (schedule.OURS, "pyelastica", "soromox")
        for case in "abcd"
    ]
    seen, threads = [], set()

    def run(job):
        seen.append(job)
        if job.program == schedule.OURS:
            threads.add(threading.get_ident())
        return 1.5

    schedule.work(jobs, run, [0, 1])
    assert sorted(map(str, seen)) == sorted(map(str, jobs))
    assert threads == {threading.get_ident()}
    assert schedule.Costs().of(jobs[0]) == 1.5


def test_a_job_that_fails_ends_the_run(tmp_path, monkeypatch):
    schedule = module("schedule")
    monkeypatch.setattr(schedule, "FILE", tmp_path / "costs.json")
    monkeypatch.setattr(schedule, "pin", lambda core: None)

    def run(job):
        raise RuntimeError(job.case)

    with pytest.raises(RuntimeError, match="a"):
        schedule.work([schedule.Job("pyelastica", "a")], run, [0, 1])


def test_tables_say_ratio_or_how_far_a_peer_got(tmp_path):
    table = module("table")
    entries = [
        {"case": "gvs", "program": program, "outcome": "completed", "wall_s": wall,
         "error_rel": error, "reference_agreement": 1e-9, "settings": {}}
        for program, wall, error in (
            ("soft_sim_ros", 0.01, 1e-3), ("soft_sim_ros", 0.1, 1e-5), ("soromox", 5.0, 1e-3),
        )
    ]  # fmt: skip
    at = {error: "\n".join(table.table_at(entries, error)) for error in table.ERRORS}
    assert "| gvs | 10 ms | – | 5 s (500×) | – | – | 500× (SoRoMoX) |" in at[1e-3]
    assert "| gvs | 0.1 s | – | no: 1e-03 in 5 s | – | – | – |" in at[1e-5]
    assert "No peer gets there" in at[1e-5]
    page = tmp_path / "page.md"
    marks = [f"<!-- {mark}: {edge} -->" for mark in ("table", "other") for edge in ("begin", "end")]
    old = "before\n{}\nold\n{}\nbetween\n{}\nold\n{}\nafter\n".format(*marks)
    page.write_text(old)
    table.put(page, "new", "other")
    assert page.read_text() == old.replace(f"{marks[2]}\nold", f"{marks[2]}\nnew")
    table.put(page, "new")
    assert page.read_text() == old.replace("\nold\n", "\nnew\n")


def test_fitted_rates_tell_spectral_from_algebraic_convergence():
    rate = module("convergence").rate
    spectral = [{"basis": "legendre", "order": n, "error_rel": 10.0**-n} for n in range(8)]
    assert rate(spectral, 1e-9)["error divided per order by"] == pytest.approx(10.0)
    square = [{"basis": "linear", "elements": n, "error_rel": n**-2.0} for n in (1, 2, 4, 8, 16)]
    assert rate(square, 1e-9)["power of the number of elements"] == pytest.approx(2.0)
