"""Put one picture of the film together: the image, the path beside it, bars and words below."""

from bisect import bisect_right

from flightstack.logs.flight.flight import Flight
from flightstack.logs.seen import SeenImages
from flightstack.logs.video.bars import command_bars, uncertainty_bars
from flightstack.logs.video.drawing import GATE, INK, LINE, MUTED, Canvas, blank, write
from flightstack.logs.video.overlay import draw_command, draw_gate, enlarged
from flightstack.logs.video.plan import PathPlan

SIDE, HEIGHT = 448, 448 + 6 * LINE + 4  # pixels, even: H.264 wants them so
TEXT_S = 4.0  # that a text stays


class FilmPictures:
    """The pictures of a flight, one an image."""

    def __init__(self, flight: Flight, seen: SeenImages) -> None:
        self._flight = flight
        self._seen = seen
        self._plan = PathPlan(flight, seen, SIDE)
        self._text_times = [text.time_us for text in flight.texts]
        self._flown = seen.flown()

    def at(self, row: int) -> Canvas:
        """Return the picture of one image, (HEIGHT, 2 SIDE, 3) RGB."""
        canvas = blank(HEIGHT, 2 * SIDE)
        canvas[:SIDE, :SIDE] = self._view(row)
        canvas[:SIDE, SIDE:] = self._plan.at(row)
        decision = int(self._seen.decision[row])
        chosen = decision if decision >= 0 else None
        command = None if chosen is None else self._flight.decisions.command[chosen]
        bars = command_bars(SIDE, command, self._flown[row])
        doubts = uncertainty_bars(SIDE, self._flight.decisions, chosen)
        canvas[SIDE : SIDE + len(bars), :SIDE] = bars
        canvas[SIDE : SIDE + len(doubts), SIDE:] = doubts
        self._words(canvas, row)
        return canvas

    def _view(self, row: int) -> Canvas:
        seen, gates = self._seen, self._flight.gates
        view = enlarged(str(seen.paths[row]), SIDE)
        decision = int(seen.decision[row])
        if gates and decision >= 0:
            due = gates[int(seen.gates_passed[row]) % len(gates)]
            draw_gate(view, due, seen.position_ned[row], seen.attitude_rad[row])
            write(view, f"gate {due.index + 1}", (8, LINE), GATE)
        if decision >= 0:
            draw_command(view, self._flight.decisions.command[decision])
        return view

    def _words(self, canvas: Canvas, row: int) -> None:
        """Write when it was, in which mode, and what was said last."""
        now_us = int(self._seen.time_us[row])
        held = [each.label for each in self._flight.modes if each.start_us <= now_us]
        mode = held[-1] if held else ""
        line = f"{self._flight.seconds(now_us):7.2f} s   {mode}"
        write(canvas, line, (SIDE + 8, SIDE + 5 * LINE), INK)
        said = bisect_right(self._text_times, now_us) - 1
        if said >= 0 and now_us - self._text_times[said] <= TEXT_S * 1e6:
            text = self._flight.texts[said].text
            write(canvas, text[:62], (SIDE + 8, SIDE + 6 * LINE), MUTED)
