"""Everything but the node and the player works where no ROS is installed."""

import subprocess
import sys

import pytest

BLOCK = "import sys; sys.modules['rclpy'] = sys.modules['rcl_interfaces'] = None; "
MODULES = (
    "soft_sim_ros.scene",
    "soft_sim_ros.core.simulation.simulation",
    "soft_sim_ros.recording.reader",
    "soft_sim_ros.recording.writer",
    "soft_sim_ros.report",
    *(
        f"soft_sim_ros.commands.{v}"
        for v in (
            "check",
            "recover",
            "report",
            "rerun",
            "rollout",
            "linearise",
            "identify",
            "derive",
        )
    ),
)


@pytest.fixture
def without_ros(environment):
    def run(code):
        command = [sys.executable, "-c", BLOCK + code]
        return subprocess.run(command, env=environment, capture_output=True, text=True)

    return run


def test_no_message_package_is_imported_either(without_ros):
    done = without_ros(
        "import importlib; [importlib.import_module(m) for m in " + repr(MODULES) + "]; "
        "print(sorted(m for m in sys.modules if m.endswith(('_msgs', '_srvs'))))"
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def test_a_scene_is_checked(without_ros):
    done = without_ros(
        "from soft_sim_ros.__main__ import main; sys.exit(main(['check','soft_arm']))"
    )
    assert done.returncode == 0, done.stderr
    assert "coordinates" in done.stdout


@pytest.mark.parametrize("verb", ["simulate", "replay", "demo"])
def test_what_needs_ros_says_so_in_one_line(without_ros, verb):
    done = without_ros(f"from soft_sim_ros.__main__ import main; sys.exit(main(['{verb}', 'x']))")
    assert done.returncode == 2
    assert done.stderr.startswith(f"error: {verb} needs ROS 2 Jazzy")
    assert len(done.stderr.strip().splitlines()) == 1


def test_the_package_itself_imports_nothing_heavy(without_ros):
    done = without_ros(
        "import soft_sim_ros; print({'numpy', 'scipy', 'numba', 'matplotlib'} & set(sys.modules))"
    )
    assert done.stdout.strip() == "set()", done.stderr
