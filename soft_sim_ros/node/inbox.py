"""The queue of the physics thread: orders and requests, carried out in order of arrival."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from soft_sim_ros.core.simulation.orders import Order

Answer = tuple[bool, str]
MOST_WAITING = 10_000  # orders between two instants of control


@dataclass
class _Request:
    action: Callable[[], Answer]
    answer: Answer = (False, "the simulation has ended")
    done: threading.Event = field(default_factory=threading.Event)


class Inbox:
    """One queue, filled by any thread and emptied by one.

    Attributes
    ----------
    wake : set when there is something that a paused simulation must look at
    asked : set while there are requests, whose callers wait for an answer
    """

    def __init__(self) -> None:
        self._items: deque[_Request | tuple[str, Order, bytes]] = deque()
        self.wake = threading.Event()
        self.asked = threading.Event()

    def submit(self, key: str, order: Order, data: bytes) -> bool:
        """Queue an order with the bytes of its message; False if too many wait already."""
        if len(self._items) >= MOST_WAITING:
            return False
        self._items.append((key, order, data))
        return True

    def ask(self, action: Callable[[], Answer], alive: Callable[[], bool]) -> Answer:
        """Queue a request and wait for its answer, as long as the other thread is alive."""
        request = _Request(action)
        self._items.append(request)
        self.asked.set()
        self.wake.set()
        while not request.done.wait(0.1):
            if not alive():
                break
        return request.answer

    def post(self, action: Callable[[], Answer]) -> None:
        """Queue a request without waiting for its answer."""
        self._items.append(_Request(action))

    def empty(self, take: Callable[[str, Order, bytes], None]) -> None:
        """Carry out the requests and hand over the orders that are here by now."""
        self.asked.clear()
        while self._items:
            item = self._items.popleft()
            if isinstance(item, _Request):
                try:
                    item.answer = item.action()
                finally:
                    item.done.set()
            else:
                take(*item)
