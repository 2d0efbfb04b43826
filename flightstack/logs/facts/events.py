"""What happens in a log while it is written: events, and rates, as they come."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.senders import AUTOPILOT_INVALID
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.modes import mode_name
from flightstack.logs.flight.texts import status_texts
from flightstack.logs.flight.vehicle import ARMED
from flightstack.logs.tlog.losses import find_losses
from flightstack.logs.tlog.packets import Packets, join
from flightstack.mavlink_numbers import REFEREE_COMPONENT


@dataclass
class LiveEvents:
    """Turns pieces of a log into events; keeps what it needs from piece to piece."""

    modes: dict[tuple[int, int], str] = field(default_factory=dict)
    armed: dict[tuple[int, int], bool] = field(default_factory=dict)
    since: list[Packets] = field(default_factory=list)  # packets since the last rates

    def of(self, log: Log) -> Iterator[Facts]:
        """Yield mode changes, arming, texts and gates of this piece, in order of time."""
        found = [*self._heartbeats(log), *self._texts(log), *self._gates(log)]
        self.since.append(log.packets)
        yield from sorted(found, key=lambda event: int(event["time_us"]))

    def _heartbeats(self, log: Log) -> Iterator[Facts]:
        beats = log["HEARTBEAT"]
        names = ("autopilot", "type", "base_mode", "custom_mode")
        columns = [beats[name].tolist() for name in names]
        sources = zip(beats.system.tolist(), beats.component.tolist(), strict=True)
        for time_us, source, autopilot, kind, base, custom in zip(
            beats.time_us.tolist(), sources, *columns, strict=True
        ):
            if autopilot == AUTOPILOT_INVALID:
                continue
            mode, armed = mode_name(autopilot, kind, base, custom), bool(base & ARMED)
            event = {"time_us": time_us, "source": f"{source[0]}/{source[1]}"}
            if self.modes.get(source) != mode:
                yield {**event, "event": "mode", "text": mode}
            if self.armed.get(source, False) != armed:
                yield {**event, "event": "armed" if armed else "disarmed", "text": ""}
            self.modes[source], self.armed[source] = mode, armed

    def _texts(self, log: Log) -> Iterator[Facts]:
        for text in status_texts(log):
            about = {"event": "text", "level": text.level, "text": text.text}
            yield {"time_us": text.time_us, "source": text.source, **about}

    def _gates(self, log: Log) -> Iterator[Facts]:
        reached = log["MISSION_ITEM_REACHED"]
        rows = zip(reached.time_us.tolist(), reached.component.tolist(), reached["seq"].tolist(),
                   reached.system.tolist(), strict=True)  # fmt: skip
        for time_us, component, seq, system in rows:
            what = "gate" if component == REFEREE_COMPONENT else "item"
            about = {"event": what, "text": f"{what} {seq} reached"}
            yield {"time_us": time_us, "source": f"{system}/{component}", **about}

    def rates(self, seconds: float) -> Facts:
        """Return messages a second and loss by source since the last call."""
        packets = join(self.since)
        self.since = []
        sources = {
            f"{loss.system}/{loss.component}": {
                "rate_hz": round(loss.received / seconds, 1),
                "loss_percent": round(100 * loss.fraction, 2),
            }
            for loss in find_losses(packets)
        }
        return {"event": "rates", "rate_hz": round(len(packets) / seconds, 1), "sources": sources}
