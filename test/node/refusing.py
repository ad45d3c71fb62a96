"""Starts the node or the replay again and again, as asked on stdin, and tells what they said.

A process of its own: one that also holds another node of ROS once waited for ever in DDS while a
second participant began. Asked with one line of JSON, ``[program, words]``; answers with
``[exit code, text]``.
"""

import json
import os
import sys
import tempfile

from soft_sim_ros.node import replay, simulate

PROGRAMS = {"simulate": simulate.main, "replay": replay.main}


class Started(Exception):
    """The node would have started."""


def warm_up(*_):
    """Stand where the arm would be made."""
    raise Started


def said_of(program: str, words: list[str]) -> tuple[int | None, str]:
    """Run a program; give its exit code (None: it would have started) and what it printed."""
    kept = os.dup(1), os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
        try:
            code = PROGRAMS[program](words)
        except Started:
            code = None
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, number)
                os.close(copy)
        file.seek(0)
        return code, file.read().decode(errors="replace")


if __name__ == "__main__":
    simulate.warm_up = warm_up
    answers = os.fdopen(os.dup(1), "w")
    for line in sys.stdin:
        json.dump(said_of(*json.loads(line)), answers)
        answers.write("\n")
        answers.flush()
