"""Write which versions this environment has of everything the package needs: a lock file.

    .venv/bin/python tools/tested.py > requirements/tested.txt

after `make test` has passed there. ``pip install -c requirements/tested.txt …`` takes the same.
"""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PACKAGE, EXTRAS = "soft_sim_ros", ("", "ros", "batch", "derive", "test")


def needed(name: str, extras: tuple[str, ...], found: dict[str, str]) -> None:
    """Add to ``found`` what a package needs, and what that needs, as name → version."""
    for text in distribution(name).requires or ():
        requirement = Requirement(text)
        marker = requirement.marker
        if marker and not any(marker.evaluate({"extra": extra}) for extra in extras):
            continue
        key = canonicalize_name(requirement.name)
        if key in found and not requirement.extras:
            continue
        try:
            found[key] = distribution(key).version
        except PackageNotFoundError:  # not for this system, or from a sourced ROS
            continue
        needed(key, ("", *requirement.extras), found)


def main() -> None:
    """Print the lock file."""
    found: dict[str, str] = {}
    needed(PACKAGE, EXTRAS, found)
    print("# Versions that the tests have passed with: a file of constraints for pip -c.")
    print(f"# Python {platform.python_version()}, {platform.system()} {platform.machine()}.")
    print("# Written by tools/tested.py; do not edit.")
    for name in sorted(found):
        print(f"{name}=={found[name]}")


if __name__ == "__main__":
    main()
