"""Build of an ordinary ament_python package that is also an ordinary pip package."""

import sys
from glob import glob
from pathlib import Path

from setuptools import Distribution, find_packages, setup

from distutils.command.install_data import install_data  # isort: skip  (setuptools brings distutils)

NAME = "soft_sim_ros"
VERBS = (
    "check",
    "simulate",
    "replay",
    "rerun",
    "recover",
    "report",
    "rollout",
    "linearise",
    "identify",
    "derive",
    "urdf",
    "demo",
)

# The one place of requirements. Lower bounds are what Ubuntu 24.04 ships, where it ships them, and
# tested by `make test-oldest`; upper bounds are the next version that may break something.
REQUIRES = [
    "numpy>=1.26.4,<3",
    "scipy>=1.11.4,<2",
    "numba>=0.58.1,<0.70",
    "llvmlite>=0.41.1,<0.53",  # numba asks for one of these exactly
    "PyYAML>=6.0.1,<7",
    "matplotlib>=3.6.3,<4",
    "mcap>=1.5,<2",
    "lz4>=4.0.2,<5",
    "zstandard>=0.22,<1",
]
EXTRAS = {
    # ROS 2 Jazzy from PyPI, for machines without a Jazzy of their own.
    "ros": ["ros-jazzy-rclpy[fastrtps]>=7.1.6,<7.2", "ros-jazzy-common-interfaces>=5.3.6,<5.4"],
    # Batches over many machines.
    "batch": ["distributed>=2023.12,<2027"],
    # scalar equations by computer algebra: the verb `derive`
    "derive": ["sympy>=1.12,<2"],
    # `make docs`: the documentation site
    "docs": ["sphinx>=7.2,<9", "myst-parser>=3,<5"],
    "test": [
        "sympy>=1.12,<2",
        "distributed>=2023.12,<2027",
        "cosseratbench>=0.3,<0.4",  # a benchmark of others, which runs this package as a solver
        "colcon-common-extensions>=0.3,<0.4",
        "setuptools>=68,<80",  # what colcon drives, which later ones no longer have
        "pytest>=7.4,<10",
        "pytest-timeout>=2.2,<3",
        "pytest-xdist>=3.5,<4",
        "hypothesis>=6.98,<7",
        "mcap-ros2-support>=0.5.5,<0.7",
        "rosbags>=0.11.9,<0.12",
        "ruff>=0.15,<0.18",
        "mypy>=1.15,<3",
        "types-PyYAML>=6.0,<7",
    ],
}

# pip builds a wheel, colcon never does. A wheel's console scripts land in bin/, where verbs such as
# `check` would be bad neighbours and where `ros2 run` does not look.
FOR_PIP = not {"dist_info", "bdist_wheel", "editable_wheel"}.isdisjoint(sys.argv)

RUN_VERB = """\
#!/bin/sh
# `ros2 run {name} {verb}`
exec "$(dirname "$0")/../../bin/{name}" {verb} "$@"
"""


class Package(Distribution):
    """A package whose editable install has data files too."""

    def has_data(self):
        """Say so under the name that setuptools' editable install asks for."""
        return self.has_data_files()


class InstallData(install_data):
    """Data files, and in a wheel the executables of `ros2 run` among them."""

    def run(self):
        """Install everything."""
        super().run()
        for verb in VERBS if FOR_PIP else ():
            path = Path(self.install_dir, "lib", NAME, verb)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(RUN_VERB.format(name=NAME, verb=verb))
            path.chmod(0o755)
            self.outfiles.append(str(path))


setup(
    name=NAME,
    version="0.1.0",
    description="Soft manipulators as Cosserat rods in ROS 2: simulate, command, record, replay",
    author="soft_sim_ros developers",
    maintainer="soft_sim_ros developers",
    maintainer_email="maintainer@example.org",
    license="Apache-2.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={"": ["py.typed", "*.html", "*.css", "*.js", "*.json", "*.txt"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", sorted(glob("config/*.yaml"))),
        (f"share/{NAME}/config/sros2", ["config/sros2/policy.xml"]),
        (f"share/{NAME}/viewers", sorted(glob("viewers/*"))),
        (f"share/{NAME}/launch", sorted(glob("launch/*.launch.py"))),
        (f"share/{NAME}/examples", sorted(glob("examples/*.py"))),
        (f"share/{NAME}/examples/ros2_control", sorted(glob("examples/ros2_control/*"))),
    ],
    python_requires=">=3.10",
    install_requires=REQUIRES,
    extras_require=EXTRAS,
    tests_require=["pytest"],
    zip_safe=False,
    distclass=Package,
    cmdclass={"install_data": InstallData},
    entry_points={
        "console_scripts": [f"{NAME} = {NAME}.__main__:main"]
        + [f"{verb} = {NAME}.commands.{verb}:main" for verb in VERBS if not FOR_PIP],
        # costs nothing where cosseratbench is not installed: only it looks for this
        "cosseratbench.solvers": [f"{NAME} = {NAME}.integrations.cosseratbench:SoftSimRos"],
    },
)
