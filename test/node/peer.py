"""The other end of the wire: a node process, and a peer that talks to it through real DDS."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import SetBool, Trigger

PROGRAM = ("-c", "import sys; from soft_sim_ros.node import main; sys.exit(main(sys.argv[1:]))")
FAULTY = (str(Path(__file__).with_name("faulty.py")),)
ROOT = Path(__file__).parents[2]
START = 240.0  # s; the first start on a machine compiles the kernels
PATIENCE = 60.0  # s; a wait ends when it is over, and a busy machine may take its time


def child_environment() -> dict[str, str]:
    """Give the environment for programs: they find this tree first, installed or not."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONUNBUFFERED": "1", "PYTHONPATH": path}


def wait_for(condition: Callable[[], Any], what: str, timeout: float = PATIENCE) -> Any:
    """Wait until ``condition()`` is true and return it; fail with ``what`` was waited for."""
    deadline = time.monotonic() + timeout
    while not (result := condition()):
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {timeout:g} s in vain for {what}")
        time.sleep(0.005)
    return result


class Program:
    """A program of this package in a process of its own."""

    _all: ClassVar[list[subprocess.Popen]] = []

    @classmethod
    def count(cls) -> int:
        """Give the number of programs started so far."""
        return len(cls._all)

    @classmethod
    def kill_since(cls, begin: int) -> None:
        """Kill what a failed test has left of the programs from number ``begin`` on."""
        for process in cls._all[begin:]:
            if process.poll() is None:
                process.kill()
                process.wait()

    def __init__(self, folder: Path, command: tuple[str, ...], *args: str):
        self.output = folder / f"output_{time.monotonic_ns()}.txt"
        with self.output.open("w") as file:
            self.process = subprocess.Popen(
                [sys.executable, *command, *args],
                stdout=file,
                stderr=subprocess.STDOUT,
                cwd=ROOT,
                env=child_environment(),
            )

        self._all.append(self.process)

    @property
    def text(self) -> str:
        """Everything it has printed."""
        return self.output.read_text()

    def wait_for_text(self, text: str, timeout: float = PATIENCE) -> None:
        """Wait until it has printed ``text``."""
        wait_for(
            lambda: text in self.text or (self.process.poll() is not None and "ended"),
            f"{text!r} in\n{self.text}",
            timeout,
        )
        assert text in self.text, f"ended without {text!r}:\n{self.text}"

    def wait(self, timeout: float = PATIENCE) -> int:
        """Wait for its end and return the exit code."""
        return self.process.wait(timeout)

    def send(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self.process.send_signal(number)

    def end(self) -> int:
        """End it as Ctrl-C does."""
        if self.process.poll() is None:
            self.send(signal.SIGINT)
        try:
            return self.wait()
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise


def simulator(
    folder: Path, *ros_args: str, program: tuple[str, ...] = PROGRAM, **parameters: object
) -> Program:
    """Start the simulator node and wait until it is ready."""
    given = [word for item in parameters.items() for word in ("-p", "{}:={}".format(*item))]
    result = Program(folder, program, "--ros-args", *given, *ros_args)
    result.wait_for_text("ready: ", START)
    return result


class Peer:
    """A node in this process with a thread that spins it."""

    def __init__(self, context: rclpy.Context):
        self.node = Node(f"peer_{time.monotonic_ns()}", context=context)
        self._publishers: list[Any] = []
        self._executor = EventsExecutor(context=context)
        self._executor.add_node(self.node)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def forget(self) -> None:
        """Take back all publishers and subscriptions; the node itself stays known to the others."""
        for subscription in list(self.node.subscriptions):
            self.node.destroy_subscription(subscription)
        for publisher in self._publishers:
            self.node.destroy_publisher(publisher)
        self._publishers.clear()

    def _spin(self) -> None:
        while not self._stop.is_set():
            self._executor.spin_once(timeout_sec=0.02)

    def close(self) -> None:
        """Leave the graph."""
        self._stop.set()
        self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()

    def listen(self, kind: type, topic: str, qos: QoSProfile | int = 100, raw: bool = False):
        """Subscribe, wait for the publisher, and return the growing list of messages."""
        messages: list[Any] = []
        subscription = self.node.create_subscription(kind, topic, messages.append, qos, raw=raw)
        wait_for(
            lambda: self.node.count_publishers(subscription.topic_name), f"publisher of {topic}"
        )
        return messages

    def talk(self, kind: type, topic: str, qos: QoSProfile | int = 1):
        """Create a publisher and wait for the subscriber."""
        publisher = self.node.create_publisher(kind, topic, qos)
        self._publishers.append(publisher)
        wait_for(publisher.get_subscription_count, f"subscriber of {topic}")
        return publisher

    def ask(self, kind: type, service: str, request: Any = None, timeout: float = PATIENCE):
        """Call a service and return the response."""
        client = self.node.create_client(kind, service)
        assert client.wait_for_service(timeout), f"no service {service}"
        future = client.call_async(request or kind.Request())
        wait_for(future.done, f"answer of {service}", timeout)
        self.node.destroy_client(client)
        return future.result()

    def trigger(self, service: str):
        """Call a service of type Trigger."""
        return self.ask(Trigger, service)

    def pause(self, pause: bool, node: str = "soft_arm"):
        """Pause or resume the simulation."""
        return self.ask(SetBool, f"{node}/pause", SetBool.Request(data=pause))
