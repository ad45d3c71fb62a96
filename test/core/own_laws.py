"""Laws of loads as a user may write them."""

from soft_sim_ros import register_load


def spring(p, rotation, position, omega, velocity, time, moment, force):
    """A spring of stiffness p[0] to the point p[1:4]."""
    for i in range(3):
        force[i] += p[0] * (p[1 + i] - position[i])


def spring_slopes(p, rotation, position, omega, velocity, time, by_pose, by_twist):
    for i in range(3):
        by_pose[3 + i, 3 + i] -= p[0]


def wrong_slopes(p, rotation, position, omega, velocity, time, by_pose, by_twist):
    for i in range(3):
        by_pose[3 + i, 3 + i] += p[0]


def undefined(p, rotation, position, omega, velocity, time, moment, force):
    """No number anywhere."""
    force[0] += (-1.0 - p[0] ** 2) ** 0.5


def magnet(p, rotation, position, omega, velocity, time, moment, force):
    """A dipole p[0] along the frame's x axis in the field p[1:4]: m × B."""
    mx, my, mz = p[0] * rotation[0, 0], p[0] * rotation[1, 0], p[0] * rotation[2, 0]
    moment[0] += my * p[3] - mz * p[2]
    moment[1] += mz * p[1] - mx * p[3]
    moment[2] += mx * p[2] - my * p[1]


def wind(p, rotation, position, omega, velocity, time, moment, force):
    """Quadratic drag p[0] against air of velocity p[1:4], and a twist that follows the frame."""
    x, y, z = p[1] - velocity[0], p[2] - velocity[1], p[3] - velocity[2]
    size = (x * x + y * y + z * z + 1e-4) ** 0.5
    force[0] += p[0] * size * x
    force[1] += p[0] * size * y
    force[2] += p[0] * size * z
    for i in range(3):
        moment[i] -= 0.1 * p[0] * omega[i] * (1.0 + rotation[i, 1] * position[0] * position[1])


register_load("spring", ("stiffness", "x", "y", "z"), spring, spring_slopes)
register_load("magnet", ("dipole", "bx", "by", "bz"), magnet)
register_load("wind", ("drag", "u", "v", "w"), wind)
