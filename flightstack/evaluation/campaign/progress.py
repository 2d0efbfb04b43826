"""Tell how far the trials are, and how long it will take: live on a terminal, else in lines."""

import time
from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from flightstack.evaluation.flights.flight import FlownTrial

LINE_EVERY_S = 30.0
WINDOW_S = 600.0  # of flights that the time left is judged by


class TrialProgress:
    """Counts trials on standard error."""

    def __init__(self, total: int, flown_before: int = 0) -> None:
        self._console = Console(stderr=True, highlight=False)
        self._total = total
        self._done = 0
        self._simulated_s = 0.0
        self._began_s = self._line_s = time.monotonic()
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=self._console,
            disable=not self._console.is_terminal,
            speed_estimate_period=WINDOW_S,
        )
        self._task = self._bar.add_task("trials", total=total)
        if flown_before:
            self.say(f"{flown_before} trials stand already, {total} are to be flown")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()
        wall_s = time.monotonic() - self._began_s
        if self._simulated_s:
            self.say(
                f"{self._done} trials: {self._simulated_s:.0f} simulated seconds "
                f"in {_clock(wall_s)}, {self._simulated_s / wall_s:.1f} a second"
            )

    def say(self, text: str) -> None:
        """Tell something that is worth a line."""
        self._console.print(text, markup=False, soft_wrap=True)

    def note(self, flown: FlownTrial) -> None:
        """Count a trial; tell of each time it died."""
        for death in flown.deaths:
            again = "flown again" if flown.flight is not None else "given up"
            self.say(f"{flown.trial}: {death}; {again}")
        self._done += 1
        self._simulated_s += 0.0 if flown.flight is None else flown.flight.simulated_s
        self._bar.update(self._task, completed=self._done)
        now_s = time.monotonic()
        is_due = now_s - self._line_s >= LINE_EVERY_S or self._done == self._total
        if self._bar.disable and is_due:
            self._line_s = now_s
            self.say(self._line(now_s - self._began_s))

    def _line(self, elapsed_s: float) -> str:
        left_s = elapsed_s / self._done * (self._total - self._done)
        return f"{self._done} of {self._total} trials in {_clock(elapsed_s)}, {_clock(left_s)} left"


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
