"""Published beams: the Princeton beam, Bathe's bend, the set-ups of Simo and Vu-Quoc."""

import numpy as np


def test_the_bend_has_the_digits_of_kynema_and_of_its_boundary_value_problem(module):
    bathe = module("bathe")
    kynema = bathe.PUBLISHED[0]
    assert np.abs(bathe.tip("parabola", 8, 2) - kynema.tip).max() < 1e-6 * bathe.LENGTH
    assert np.abs(bathe.tip("circle", 8, 2) - bathe.exact()).max() < 1e-6 * bathe.LENGTH


def test_older_published_tips_of_the_bend_scatter_within_their_two_digits(module):
    bathe = module("bathe")
    circle = bathe.tip("circle", 6, 1)
    for published in bathe.PUBLISHED[1:]:
        assert np.abs(circle - published.tip).max() < 0.005 * bathe.LENGTH


def test_the_princeton_beam_bends_as_in_other_programs(module):
    princeton = module("princeton")
    points = princeton.points()
    assert len(points) == 14
    for point in (points[3], points[9]):
        force, angle = point["P_N"], np.radians(point["beta_deg"])
        own = princeton.tip(force, angle, None, 5)
        paper = princeton.tip(force, angle, princeton.torsion_of_paper(), 5)
        for program, mine, allowed in (("ansys_beam", own, 4e-4), ("exudyn16", paper, 7e-4)):
            theirs = [point[f"uy_{program}"], point[f"uz_{program}"]]
            assert np.linalg.norm(mine - theirs) < allowed * princeton.LENGTH, program


def test_the_torsion_constant_decides_between_the_published_programs(module):
    princeton = module("princeton")
    point = princeton.points()[3]
    force, angle = point["P_N"], np.radians(point["beta_deg"])
    own = princeton.tip(force, angle, None, 5)
    paper = princeton.tip(force, angle, princeton.torsion_of_paper(), 5)
    lag = {name: point[f"uy_{name}"] for name in ("ansys_beam", "exudyn16")}
    assert abs(own[0] - lag["ansys_beam"]) < abs(paper[0] - lag["ansys_beam"])
    assert abs(paper[0] - lag["exudyn16"]) < abs(own[0] - lag["exudyn16"])


def test_the_beam_in_flight_takes_up_the_impulse_of_its_load(module):
    vu_quoc = module("vu_quoc")
    places, simulation = vu_quoc.run(vu_quoc.flying(10, 3, 2, 1e-5), 10, 2, (0, 1))
    assert np.allclose(places[0], [[6, 0, 0], [0, 8, 0]], atol=1e-12)
    momentum = simulation.dynamics.momentum(simulation.q, simulation.v)
    assert np.abs(momentum[3:] - [20.0, 0.0, 0.0]).max() < 0.02
    spin = -80.0 * 2.5  # and the moment of the force about the origin, which the motion decides
    assert momentum[2] < spin


def test_the_elbow_swings_as_the_printed_curves_say(module):
    vu_quoc = module("vu_quoc")
    printed = vu_quoc.digitised()
    outputs = 60  # of half a second, of which the first twelve are run
    places, _ = vu_quoc.run(vu_quoc.elbow(outputs, 2, 1, 1e-5), 12, 3, (1, 2))
    times = 0.5 * np.arange(13)
    for k, name in enumerate(("corner", "tip")):
        figure = np.interp(times, *printed[name])
        assert np.abs(places[:, k, 2] - figure).max() < 0.04 * 10, name
        assert np.abs(figure).max() > 5.0
