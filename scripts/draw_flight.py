"""Draw a flight from its log: the path over the gates, and what the camera saw at each gate.

    python scripts/draw_flight.py LOG --track-seed 7 --noise 1.0,2.0 --output docs/flight.png

The log tells where the vehicle was and how sure each decision; the images are rendered again, at
the logged poses, by the simulator's own camera.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flightstack.errors import FlightstackError
from flightstack.logs import Log, read
from flightstack.mavlink_numbers import REFEREE_COMPONENT
from sitl import (
    GATE_OUTER_M,
    Camera,
    Gate,
    SimulationConfig,
    SitlError,
    Track,
    look_of_day,
    make_track,
)

FRAMES = 8  # images in the strip
BEFORE_GATE_S = 0.9  # what the camera sees this long before a gate is passed
VEHICLE = 1  # component
EPISTEMIC = slice(4, 8)  # in DEBUG_FLOAT_ARRAY "decision": docs/wire.md
INK, MUTED, GATE = "#22272e", "#8a939e", "#d9480f"


@dataclass(frozen=True, slots=True, kw_only=True)
class Path3:
    """Where the vehicle was while the network flew, one row a decision."""

    time_ms: NDArray[np.float64]  # (K,) since boot
    position_ned: NDArray[np.float64]  # (K, 3) m
    q_ned_frd: NDArray[np.float64]  # (K, 4) w, x, y, z
    speed_m_s: NDArray[np.float64]  # (K,)
    epistemic_m_s: NDArray[np.float64]  # (K,) norm over the three velocities
    passed_ms: NDArray[np.float64]  # (gates passed,) since boot


def read_path(log: Log) -> Path3:
    """Put position, attitude and uncertainty on the times of the decisions."""
    place = log["LOCAL_POSITION_NED"].where(component=VEHICLE)
    attitude = log["ATTITUDE_QUATERNION"].where(component=VEHICLE)
    decision = log["DEBUG_FLOAT_ARRAY"]
    reached = log["MISSION_ITEM_REACHED"].where(component=REFEREE_COMPONENT)
    time_ms = decision["time_usec"] / 1e3

    def on_decisions(
        table_ms: NDArray[np.float64], column: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        return np.interp(time_ms, table_ms, column.astype(np.float64))

    place_ms, attitude_ms = place["time_boot_ms"], attitude["time_boot_ms"]
    velocity = [on_decisions(place_ms, place[name]) for name in ("vx", "vy", "vz")]
    boot_us = np.median(place.time_us - place_ms * 1000.0)
    return Path3(
        time_ms=time_ms,
        position_ned=np.stack([on_decisions(place_ms, place[name]) for name in "xyz"], axis=1),
        q_ned_frd=np.stack(
            [on_decisions(attitude_ms, attitude[name]) for name in ("q1", "q2", "q3", "q4")], axis=1
        ),
        speed_m_s=np.linalg.norm(velocity, axis=0),
        epistemic_m_s=np.linalg.norm(decision["data"][:, EPISTEMIC][:, :3], axis=1),
        passed_ms=(reached.time_us - boot_us) / 1e3,
    )


def draw_course(axes: Axes, path: Path3, track: Track) -> None:
    """Draw the flight from above: colour is how far the policies disagree."""
    points = path.position_ned[:, [1, 0]]
    segments = np.stack([points[:-1], points[1:]], axis=1)
    line = LineCollection(segments.tolist(), cmap="viridis", linewidths=2.6, capstyle="round")
    line.set_array(path.epistemic_m_s[:-1])
    line.set_clim(0.0, float(np.quantile(path.epistemic_m_s, 0.98)))
    axes.add_collection(line)
    for gate in track.gates:
        draw_gate(axes, gate, track)
    axes.plot(0.0, 0.0, marker="o", color=INK, markersize=5)
    axes.annotate(
        "take-off",
        (0.0, 0.0),
        xytext=(8, 0),
        textcoords="offset points",
        va="center",
        color=INK,
        fontsize=8,
    )
    axes.set_aspect("equal")
    axes.margins(0.12)
    axes.set(xlabel="east, m", ylabel="north, m")
    axes.spines[["top", "right"]].set_visible(False)
    bar = axes.figure.colorbar(line, ax=axes, shrink=0.7, pad=0.03)
    bar.set_label("disagreement of the policies (epistemic std), m/s")


def draw_gate(axes: Axes, gate: Gate, track: Track) -> None:
    """Draw one gate as the bar it is from above, with its number outside the circle."""
    north, east, down = gate.centre_ned
    right = np.array([np.cos(gate.yaw_rad), -np.sin(gate.yaw_rad)])  # east, north
    ends = np.array([east, north]) + np.outer([-1.0, 1.0], right * GATE_OUTER_M / 2)
    axes.plot(ends[:, 0], ends[:, 1], color=GATE, linewidth=4, solid_capstyle="butt")
    outward = np.array([east - track.centre_ned[1], north - track.centre_ned[0]])
    label = np.array([east, north]) + 1.7 * outward / np.linalg.norm(outward)
    text = f"{gate.index + 1}\n{-down:.1f} m"
    axes.text(
        label[0], label[1], text, ha="center", va="center", color=INK, fontsize=8, linespacing=0.95
    )


def draw_strip(figure: Figure, path: Path3, track: Track, seed: int) -> None:
    """Render what the camera saw shortly before each gate of the first lap."""
    camera = Camera(track.gates, look_of_day(SimulationConfig(seed=seed)))
    strip = figure.add_gridspec(
        1, FRAMES, left=0.02, right=0.98, bottom=0.02, top=0.155, wspace=0.06
    )
    for index, passed_ms in enumerate(path.passed_ms[:FRAMES]):
        row = int(
            np.searchsorted(path.time_ms, passed_ms - BEFORE_GATE_S * 1e3).clip(
                0, len(path.time_ms) - 1
            )
        )
        x, y, z = path.position_ned[row].tolist()
        qw, qx, qy, qz = path.q_ned_frd[row].tolist()
        axes = figure.add_subplot(strip[0, index])
        axes.imshow(camera.render((x, y, z), (qw, qx, qy, qz)), interpolation="nearest")
        axes.set_title(f"gate {index + 1}", fontsize=8, color=MUTED, pad=3)
        axes.axis("off")
    camera.close()


def draw(log: Log, track: Track, seed: int, output: Path) -> None:
    """Draw both parts on one page."""
    path = read_path(log)
    if not len(path.time_ms):
        raise FlightstackError(f"{log.name}: no decisions in this log, nothing to draw")
    figure = Figure(figsize=(8.4, 8.2), dpi=110, facecolor="white")
    course = figure.add_axes((0.09, 0.24, 0.87, 0.71))
    draw_course(course, path, track)
    seconds = (path.time_ms[-1] - path.time_ms[0]) / 1e3
    speed_m_s = float(path.speed_m_s.mean())
    title = f"{len(path.passed_ms)} gates in {seconds:.0f} s, {speed_m_s:.1f} m/s on average"
    course.set_title(title, color=INK, loc="left")
    draw_strip(figure, path, track, seed)
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output)


def main() -> int:
    """Draw what the command line asks for."""
    parser = argparse.ArgumentParser(
        prog="draw_flight.py", description="Draw a flight from its log."
    )
    parser.add_argument("log", type=Path, help="the companion's tlog")
    parser.add_argument("--track-seed", type=int, default=0, help="as flown (default 0)")
    parser.add_argument("--noise", default="1.0,2.0", metavar="GRN,GHN", help="as flown")
    parser.add_argument(
        "--seed", type=int, default=0, help="the vehicle's seed: the look of the day"
    )
    parser.add_argument("--output", type=Path, default=Path("docs/flight.png"))
    options = parser.parse_args()
    try:
        radius_m, height_m = (float(figure) for figure in options.noise.split(","))
        track = make_track(options.track_seed, radius_noise_m=radius_m, height_noise_m=height_m)
        draw(read(options.log), track, options.seed, options.output)
    except (FlightstackError, SitlError) as error:
        print(f"draw_flight.py: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
