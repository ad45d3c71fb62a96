"""Says when a recording gets into trouble."""

from __future__ import annotations

from collections.abc import Callable

from soft_sim_ros.foreign import one_line


class LogTrouble:
    """Complains once when recording begins to fail, and once when messages begin to be lost.

    Parameters
    ----------
    log : BagWriter or None
        What is watched.
    complain : callable
        Called with a message.
    """

    def __init__(self, log, complain: Callable[[str], None]):
        self._log, self._complain = log, complain
        self._known = (False, False)

    def look(self) -> None:
        """See whether anything is new."""
        log = self._log
        if log is None:
            return
        trouble = (log.error is not None, log.dropped > 0)
        if trouble != self._known:
            self._known = trouble
            lost = f", {log.dropped} messages dropped so far" if log.dropped else ""
            why = one_line(log.error or "too slow")
            self._complain(f"recording is in trouble: {why}{lost}")
