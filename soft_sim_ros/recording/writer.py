"""Recording in a thread of its own: non-blocking, bounded memory, survives a full disk."""

from __future__ import annotations

import atexit
import json
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path

from soft_sim_ros.endings import undisturbed
from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.bag import SPLIT_BYTES, Bag, channel
from soft_sim_ros.recording.losses import Losses
from soft_sim_ros.recording.machine import machine_facts
from soft_sim_ros.recording.topics import Topic

LIMIT_BYTES = 64 * 1024 * 1024
FLUSH_PERIOD = 0.25  # s of wall time; what a SIGKILL may cost, together with the poll period
_POLL_PERIOD = 0.01  # s
_RETRY_PERIOD = 0.25  # s between attempts on a disk that failed
_LOOK_PERIOD = 0.25  # s between looks at whether the files are still there
CLOSING_PATIENCE = 3.0  # s for which closing waits for a disk that fails
_OVERHEAD = 160  # bytes that a queued message costs beyond its data
_BURST = 8  # messages taken before the interpreter is left to other threads ...
_BACKLOG = 1024 * 1024  # ... as long as the queue is shorter than this, bytes


class BagWriter:
    """Writes messages into a rosbag2 directory from a thread of its own.

    ``write`` puts a message into a queue and returns at once. While the disk fails or lags, the
    queue fills; what no longer fits is dropped and counted. When the disk works again, the queue
    goes to it and the recording goes on. No error of the disk ever reaches the caller of ``write``;
    the last one is kept in ``error``. If another program deletes or moves the file that is being
    written, nothing more is recorded: ``recording`` says so, and what follows is counted.

    Parameters
    ----------
    directory : where the recording goes; made if missing, refused if it holds a recording
    topics : what may be written, by key
    metadata : facts about the run, by name
    attachments : files kept inside the recording, such as ``scene.yaml``; ``machine.json`` is
        added
    limit_bytes : size of the queue
    split_bytes : size at which a new MCAP file is begun
    on_loss : called with a message, from the disk thread, when files are removed

    Raises
    ------
    RecordingError
        if the directory holds a recording, or cannot be written to
    """

    def __init__(
        self,
        directory: str | Path,
        topics: Sequence[Topic],
        *,
        metadata: Mapping[str, str] | None = None,
        attachments: Mapping[str, bytes] | None = None,
        limit_bytes: int = LIMIT_BYTES,
        split_bytes: int = SPLIT_BYTES,
        on_loss: Callable[[str], None] = lambda text: None,
    ) -> None:
        begun = datetime.now().astimezone().isoformat(" ", "seconds")
        facts = json.dumps({"recorded": begun} | machine_facts(), indent=1).encode()
        self.directory = Path(directory)
        self.limit_bytes = limit_bytes
        self.error: str | None = None
        self.complete = False
        self._on_loss = on_loss
        self._topics = tuple(topics)
        self._index = {topic.key: index for index, topic in enumerate(self._topics)}
        self._bag = Bag(
            self.directory,
            [channel(topic) for topic in self._topics],
            metadata=metadata or {},
            attachments={"machine.json": facts, **(attachments or {})},
            split_bytes=split_bytes,
        )
        # `_entered` and what is dropped belong to the writers (behind `_gate`), `_left` and what is
        # lost to the disk thread, which therefore never holds a lock that a writer waits for
        self._gate = threading.Lock()
        self._queue: deque[tuple[int, int, bytes]] = deque()
        self._entered = 0
        self._left = 0
        self._losses = Losses([topic.name for topic in self._topics])
        self._written = 0
        self._open = True
        self._failing = False
        self._committed_at = self._tried_at = self._looked_at = time.monotonic()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="bag writer", daemon=True)
        self._thread.start()
        atexit.register(self.close)

    @property
    def written(self) -> int:
        """Number of messages on disk."""
        return self._written

    @property
    def dropped(self) -> int:
        """Number of messages that will never be on disk."""
        return self._losses.total

    @property
    def dropped_by_topic(self) -> dict[str, int]:
        """Number of messages lost, by topic name; topics without losses are left out."""
        return self._losses.by_topic

    @property
    def queued_bytes(self) -> int:
        """Bytes in the queue."""
        return self._entered - self._left

    @property
    def recording(self) -> bool:
        """Whether messages are still taken."""
        return self._open

    @property
    def failing(self) -> bool:
        """Whether the disk refused the last attempt."""
        return self._failing

    def write(self, key: str, time_ns: int, data: bytes) -> bool:
        """Queue one message; never blocks.

        Parameters
        ----------
        key : of one of the topics
        time_ns : simulation time in ns, not negative: log time and publish time
        data : the message as CDR

        Returns
        -------
        bool
            False if the message was dropped (and counted), because the queue is full or the
            recording is closed
        """
        index = self._index.get(key)
        if index is None:
            reason = f"has no topic {key!r}; it has {', '.join(self._index)}"
            raise RecordingError(self.directory, reason)
        if time_ns < 0:
            raise ValueError(f"time_ns = {time_ns} for {key}: expected a time of at least 0")
        size = len(data) + _OVERHEAD
        with self._gate:
            if not self._open or self._entered - self._left + size > self.limit_bytes:
                self._losses.drop(index)
                return False
            self._entered += size
            self._queue.append((index, time_ns, data))
        return True

    def wait_for_room(self, timeout: float = 10.0) -> bool:
        """Wait until the queue is at most half full: for runs faster than real time.

        Returns False if the disk fails or ``timeout`` s pass first.
        """
        deadline = time.monotonic() + timeout
        while self.queued_bytes > self.limit_bytes // 2:
            if self._failing or time.monotonic() > deadline:
                return False
            time.sleep(0.002)
        return True

    def close(self, timeout: float = 30.0) -> None:
        """Write what is queued, complete the recording and stop; a second call does nothing.

        A disk that fails is tried again for CLOSING_PATIENCE s. What it does not take is counted,
        and the recording stays torn, readable up to there: ``complete`` tells. Signals wait.
        """
        with self._gate:
            self._open = False
        self._stop.set()
        with undisturbed():
            self._thread.join(timeout)
        if self._thread.is_alive():
            self.error = f"{self.directory}: the disk did not take the rest within {timeout:g} s"
        atexit.unregister(self.close)

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            while not self._stop.wait(_POLL_PERIOD):
                self._work()
                if not self._there():
                    return
            self._finish()
        except Exception as reason:  # a thread that dies must say so, and must not keep a queue
            self._fail(f"{type(reason).__name__}: {reason}")
            self._give_up()

    def _there(self, at_once: bool = False) -> bool:
        """Look now and then for the files; without the one being written the recording ends."""
        now = time.monotonic()
        if now - self._looked_at < _LOOK_PERIOD and not at_once:
            return True
        self._looked_at = now
        for file in self._bag.gone():
            self._losses.lose(file.counts)
            self._written = sum(self._bag.kept().values())
            self.error = f"{self.directory / file.path} was deleted or moved away"
            self._on_loss(self.error)
        if not (trouble := self._bag.trouble()):
            return True
        try:
            self._bag.let_go()
        except OSError:
            self._failing = True  # a full disk, too; what the moved file holds counts
        self._give_up()
        self.error = f"{trouble}: nothing is recorded any more"
        self._on_loss(self.error)
        return False

    def _work(self) -> None:
        """Take over what is queued, and flush when it is time."""
        now = time.monotonic()
        if self._failing and now - self._tried_at < _RETRY_PERIOD:
            return
        self._tried_at = now
        try:
            if self._failing:
                self._commit()
            self._take()
            if now - self._committed_at >= FLUSH_PERIOD:
                self._commit()
        except OSError as reason:
            self._fail(f"{reason.strerror} (errno {reason.errno})")

    def _take(self) -> None:
        count = 0
        while self._queue:
            index, time_ns, data = self._queue[0]
            self._bag.add(index, time_ns, data)
            self._queue.popleft()  # only now: what is not taken is still there to be counted
            self._left += len(data) + _OVERHEAD
            if self._bag.staged:  # a chunk is full
                self._commit()
            count += 1
            if count % _BURST == 0 and self.queued_bytes < _BACKLOG:
                time.sleep(0.0001)  # other threads wait for the interpreter, not for the queue

    def _commit(self) -> None:
        self._bag.commit()
        self._failing = False
        self._committed_at = time.monotonic()
        self._written = sum(self._bag.kept().values())

    def _finish(self) -> None:
        deadline = time.monotonic() + CLOSING_PATIENCE
        while self._there(at_once=True):
            try:
                if self._failing:
                    self._commit()
                self._take()
                self._bag.close()
                self._written = sum(self._bag.kept().values())
                self._failing = False
                self.complete = True
                return
            except OSError as reason:
                self._fail(f"{reason.strerror} (errno {reason.errno})")
            if time.monotonic() > deadline:
                self._give_up()
                return
            time.sleep(_RETRY_PERIOD)

    def _fail(self, reason: str) -> None:
        self._failing = True
        self.error = f"{self.directory}: {reason}"

    def _give_up(self) -> None:
        """Count everything that is not on disk as lost."""
        with self._gate:
            self._open = False
        taken, kept = self._bag.taken(), self._bag.kept()
        self._written = sum(kept.values())
        self._losses.lose({name: count - kept.get(name, 0) for name, count in taken.items()})
        while self._queue:
            index, _, data = self._queue.popleft()
            self._left += len(data) + _OVERHEAD
            self._losses.lose({self._topics[index].name: 1})
        try:
            self._bag.abandon()
        except OSError as reason:
            self._fail(f"{reason.strerror} (errno {reason.errno})")
