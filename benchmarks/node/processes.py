"""Processes that are gone at the end of a block, and what they have cost so far."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
TICK = os.sysconf("SC_CLK_TCK")


class Process:
    """A Python program with its standard input and output as pipes."""

    def __init__(self, words: list[str], domain: int) -> None:
        environment = os.environ | {
            "PYTHONUNBUFFERED": "1",
            "PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH")))),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
        }
        self.popen = subprocess.Popen(
            [sys.executable, *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=environment,
        )
        self.last_words = ""

    def wait_for(self, text: str) -> str:
        """Return the line that holds ``text``; what comes before is passed over."""
        assert self.popen.stdout is not None
        said = []
        for line in self.popen.stdout:
            said.append(line)
            if text in line:
                return line
        raise RuntimeError(f"ended without {text!r}:\n{''.join(said)}")

    def result(self) -> dict[str, Any]:
        """End a peer by a line on its input, and return what it says then."""
        assert self.popen.stdin is not None
        self.popen.stdin.write("\n")
        self.popen.stdin.flush()
        answer: dict[str, Any] = json.loads(self.wait_for("{"))
        return answer

    def end(self) -> None:
        """Interrupt it, wait, and kill what does not end in order."""
        if self.popen.poll() is None:
            self.popen.send_signal(signal.SIGINT)
        try:
            self.last_words = self.popen.communicate(timeout=20.0)[0]
        except subprocess.TimeoutExpired:
            self.popen.kill()
            self.popen.communicate()

    def cpu(self) -> float:
        """Return the CPU time in s of all its threads, user and system."""
        return sum(_ticks(Path(f"/proc/{self.popen.pid}/stat"))[1:]) / TICK

    def threads(self) -> dict[str, float]:
        """Return the CPU time in s by thread, as ``name-id``; the main thread is ``main``."""
        found = {}
        for folder in Path(f"/proc/{self.popen.pid}/task").iterdir():
            name, user, system = _ticks(folder / "stat")
            main = int(folder.name) == self.popen.pid
            found["main" if main else f"{name}-{folder.name}"] = (user + system) / TICK
        return found

    def switches(self) -> int:
        """Return how often its threads have gone to sleep of their own accord."""
        count = 0
        for status in Path(f"/proc/{self.popen.pid}/task").glob("*/status"):
            for line in status.read_text().splitlines():
                if line.startswith("voluntary_ctxt_switches"):
                    count += int(line.split()[1])
        return count


def _ticks(stat: Path) -> tuple[str, int, int]:
    """Return the name of a process or thread, and its user and system time in ticks."""
    before, _, after = stat.read_text().rpartition(")")
    fields = after.split()
    return before.partition("(")[2], int(fields[11]), int(fields[12])


@contextmanager
def process(words: list[str], domain: int) -> Iterator[Process]:
    """Start a program that is gone at the end of the block, whatever happens."""
    started = Process(words, domain)
    try:
        yield started
    finally:
        started.end()
