"""``python -m soft_sim_ros VERB …``, also installed as ``soft_sim_ros VERB …``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from soft_sim_ros.commands import VERBS
from soft_sim_ros.commands.shell import verb
from soft_sim_ros.version import __version__


@verb  # signals that come while modules are loaded count, too
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb that comes first; the rest is its own."""
    verbs = "\n".join(f"  {name:9} {what}" for name, what in VERBS.items())
    parser = argparse.ArgumentParser(
        prog="soft_sim_ros",
        description="Simulate soft manipulators, and look after their recordings:\n" + verbs,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=__version__)
    parser.add_argument("verb", choices=VERBS, metavar="VERB")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, metavar="…")
    options = parser.parse_args(argv)
    if options.verb == "check":  # its matrices are small: threads would wait for one another
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    module = import_module(f"soft_sim_ros.commands.{options.verb}")
    result: int = module.main(options.arguments)
    return result


if __name__ == "__main__":
    sys.exit(main())
