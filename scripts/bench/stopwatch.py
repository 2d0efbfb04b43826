"""Charge CPU time to named parts of a program, without touching its code.

Each timed function is charged what its thread spends in it, less what timed functions that it
calls are charged. Waiting costs nothing. A snapshot of all charges is kept every few milliseconds,
so that any stretch of the run can be looked at afterwards.
"""

import functools
import threading
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

SNAPSHOT_S = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """All charges up to one moment."""

    wall_s: float  # monotonic: the same clock in all processes of a machine
    process_cpu_s: float
    cpu_s: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)


class Stopwatch:
    """CPU seconds by part, over all threads."""

    def __init__(self) -> None:
        self.snapshots: list[Snapshot] = []
        self._cpu_s: dict[str, float] = defaultdict(float)
        self._calls: dict[str, int] = defaultdict(int)
        self._lock = threading.Lock()
        self._local = threading.local()

    def watch(self, owner: Any, name: str, part: str) -> None:
        """Replace `owner.name`, a function or a method, by one that is timed as `part`."""
        function = getattr(owner, name)

        @functools.wraps(function)
        def timed(*args: Any, **kwargs: Any) -> Any:
            return self._charge(part, function, args, kwargs)

        setattr(owner, name, timed)

    def _charge(
        self, part: str, function: Callable[..., Any], args: Any, kwargs: dict[str, Any]
    ) -> Any:
        stack = self._stack()
        stack.append(0.0)  # what inner parts take
        started_s = time.thread_time()
        try:
            return function(*args, **kwargs)
        finally:
            spent_s = time.thread_time() - started_s
            inner_s = stack.pop()
            if stack:
                stack[-1] += spent_s
            with self._lock:
                self._cpu_s[part] += spent_s - inner_s
                self._calls[part] += 1
                self._keep()

    def _keep(self) -> None:
        now_s = time.monotonic()
        if self.snapshots and now_s - self.snapshots[-1].wall_s < SNAPSHOT_S:
            return
        self.snapshots.append(
            Snapshot(
                wall_s=now_s,
                process_cpu_s=time.process_time(),
                cpu_s=dict(self._cpu_s),
                calls=dict(self._calls),
            )
        )

    def _stack(self) -> list[float]:
        if not hasattr(self._local, "stack"):
            self._local.stack = []
        stack: list[float] = self._local.stack
        return stack
