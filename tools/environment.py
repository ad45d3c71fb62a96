"""Make the Python environment of this source tree, or see that it is there already.

Run by ``make``; needs nothing but a Python with ``venv``. Where a ROS 2 Jazzy is sourced, the
environment stands on top of it and only what is missing comes from PyPI; elsewhere ROS itself comes
from PyPI too. A stamp inside the environment says what it was made from, so that a second call
costs nothing and a change of the requirements is noticed.

``environment.py VENV`` installs what running needs, ``environment.py VENV test`` what tests need
besides. Kernels of the default arm are compiled while ROS is being unpacked.
"""

import ast
import hashlib
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHONS = ((3, 10), (3, 13))
STAMP, LOG, KERNELS = "soft_sim_ros.stamp", "pip.log", "kernels.log"


class Refused(Exception):
    """The environment cannot be had on this machine; the message says why and what helps."""


def sourced_jazzy() -> bool:
    """Whether this shell has a ROS 2 Jazzy whose Python client this interpreter can import."""
    distro = os.environ.get("ROS_DISTRO", "")
    if distro not in ("", "jazzy"):
        raise Refused(
            f"ROS 2 '{distro}' is sourced in this shell, but this package is for Jazzy.\n"
            "Source a Jazzy instead, or open a shell with no ROS: then it comes from PyPI."
        )
    if distro == "":
        return False
    probe = subprocess.run([sys.executable, "-c", "import rclpy"], capture_output=True, text=True)
    if probe.returncode:
        why = (probe.stderr.strip().splitlines() or ["no reason given"])[-1]
        raise Refused(
            f"ROS 2 Jazzy is sourced, but {sys.executable} cannot import its rclpy ({why}).\n"
            "Call `make PYTHON=/usr/bin/python3`, or open a shell with no ROS sourced."
        )
    return True


def check_machine(jazzy: bool) -> None:
    """Refuse a machine that the packages are not made for."""
    version = sys.version_info[:2]
    if not PYTHONS[0] <= version <= PYTHONS[1]:
        low, high = (".".join(map(str, v)) for v in PYTHONS)
        raise Refused(
            f"{sys.executable} is Python {platform.python_version()}; needed is {low} to {high}.\n"
            "Call `make PYTHON=python3.12` or another one that you have."
        )
    if not jazzy and (sys.platform != "linux" or platform.machine() != "x86_64"):
        raise Refused(
            f"This is {platform.system()} on {platform.machine()}; ROS 2 Jazzy comes from PyPI for "
            "Linux on x86_64 only.\nInstall ROS 2 Jazzy, source it, and call make again."
        )
    if importlib.util.find_spec("venv") is None or importlib.util.find_spec("ensurepip") is None:
        raise Refused(
            f"{sys.executable} cannot make virtual environments.\n"
            f"On Debian and Ubuntu: sudo apt install python{version[0]}.{version[1]}-venv"
        )


def description(jazzy: bool, tests: bool) -> str:
    """Everything the environment depends on, as text."""
    digest = hashlib.sha256()
    for name in ("setup.py", "setup.cfg", "package.xml", "tools/environment.py"):
        digest.update((ROOT / name).read_bytes())
    ros = "sourced" if jazzy else "from PyPI"
    return (
        f"python {platform.python_version()} {sys.base_prefix}\nROS 2 Jazzy {ros}\n"
        f"tree {ROOT}\nrequirements {digest.hexdigest()}\nfor {'tests' if tests else 'running'}\n"
    )


def fits(venv: Path, jazzy: bool) -> bool:
    """Whether ``venv`` is a virtual environment of this Python, open to a sourced ROS or not."""
    config = dict(
        (key.strip(), value.strip())
        for key, _, value in (
            line.partition("=") for line in (venv / "pyvenv.cfg").read_text().splitlines()
        )
    )
    return (
        config.get("version") == platform.python_version()
        and config.get("include-system-site-packages") == str(jazzy).lower()
        and (venv / "bin" / "python").exists()
    )


def create(venv: Path, jazzy: bool) -> None:
    """Make an empty environment."""
    print(f"making {venv} with Python {platform.python_version()}", flush=True)
    options = ["--system-site-packages"] if jazzy else []
    try:
        made = subprocess.run(
            [sys.executable, "-m", "venv", *options, str(venv)], capture_output=True, text=True
        )
    except KeyboardInterrupt:
        shutil.rmtree(venv, ignore_errors=True)
        raise
    if made.returncode:
        shutil.rmtree(venv, ignore_errors=True)
        raise Refused(f"python -m venv failed:\n{made.stdout}{made.stderr}".rstrip())


def ros_packages() -> list[str]:
    """Give the requirements of ROS that setup.py names, read without running it."""
    for node in ast.parse((ROOT / "setup.py").read_text()).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "EXTRAS":
            return list(ast.literal_eval(node.value)["ros"])
    raise Refused("setup.py names no packages of ROS")


def install(venv: Path, jazzy: bool, tests: bool) -> None:
    """Install this tree, editable, with what it needs."""
    size = "" if jazzy else f", about {400 if tests else 300} MB the first time"
    print(f"installing packages{size} (details: {venv / LOG})", flush=True)
    (venv / LOG).unlink(missing_ok=True)
    if tests:
        pip(venv, "--editable", f"{ROOT}[{'test' if jazzy else 'ros,test'}]")
        return
    pip(venv, "--editable", str(ROOT))
    if not jazzy:
        # Unpacking keeps one core busy and needs nothing of the library: the other one compiles.
        kernels = [str(venv / "bin" / "python"), str(ROOT / "tools" / "warm_up.py"), "soft_arm"]
        with (venv / KERNELS).open("w") as log:
            compiler = subprocess.Popen(kernels, stdout=log, stderr=subprocess.STDOUT)
        try:
            pip(venv, *ros_packages())
        except BaseException:
            compiler.terminate()
            raise
        finally:
            compiler.wait()  # what it has not compiled, the first start compiles, and says why not


def pip(venv: Path, *what: str) -> None:
    """Let pip install something, and show what it is doing."""
    command = [
        *(str(venv / "bin" / "python"), "-m", "pip", "install", "--no-input", "--no-compile"),
        *("--disable-pip-version-check", "--progress-bar", "off", *what),
    ]
    with (venv / LOG).open("a") as log:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        assert process.stdout is not None
        shown, count = time.monotonic(), 0
        for line in process.stdout:
            log.write(line)
            word, _, rest = line.strip().partition(" ")
            count += word == "Collecting"
            if line.startswith("Installing collected packages"):
                print(f"  unpacking {line.count(',') + 1} packages", flush=True)
            elif word in ("Collecting", "Downloading") and time.monotonic() - shown > 2.0:
                shown = time.monotonic()
                print(f"  package {count}: {rest.split(' ')[0]}", flush=True)
        if process.wait():
            log.flush()
            last = "\n  ".join((venv / LOG).read_text().splitlines()[-12:])
            raise Refused(f"pip ended with exit code {process.returncode}; it said last:\n  {last}")


def make(venv: Path, tests: bool = False) -> None:
    """Bring ``venv`` to what this tree asks for; what tests need is enough for running, too."""
    jazzy = sourced_jazzy()
    wanted = description(jazzy, tests)
    stamp = venv / STAMP
    present = stamp.read_text() if stamp.is_file() else ""
    if present in (wanted, description(jazzy, tests=True)):
        return
    # an environment with the tests keeps them when requirements change
    if present.endswith("for tests\n"):
        tests, wanted = True, description(jazzy, tests=True)
    check_machine(jazzy)
    start = time.monotonic()
    if venv.exists() and not (stamp.is_file() or (venv / "pyvenv.cfg").is_file()):
        raise Refused(f"{venv} exists and is not a virtual environment: move it away.")
    if venv.exists() and not fits(venv, jazzy):
        if not stamp.is_file():
            raise Refused(f"{venv} is of another Python and was not made by make: move it away.")
        print(f"{venv} was made for another Python or ROS: starting anew", flush=True)
        shutil.rmtree(venv)
    if not venv.exists():
        create(venv, jazzy)
    stamp.write_text("unfinished\n")
    install(venv, jazzy, tests)
    stamp.write_text(wanted)
    print(f"environment ready after {time.monotonic() - start:.0f} s", flush=True)


def main() -> int:
    """Make the environment named on the command line."""
    try:
        make(Path(sys.argv[1] if len(sys.argv) > 1 else ".venv"), "test" in sys.argv[2:])
    except Refused as reason:
        print(reason, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted; call make again to go on", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
