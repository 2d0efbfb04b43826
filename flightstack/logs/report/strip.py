"""Draw the moments before a failed gate as a strip: picture, command, members, uncertainty."""

import base64
from html import escape

import numpy as np

from flightstack.logs.flight.decisions import ALL_MEMBERS, UNITS, VELOCITIES
from flightstack.logs.flight.why import FailedGate, Moment
from flightstack.logs.report.plotting import PART_COLOURS, Floats

DOTS_WIDTH, DOTS_ROW = 128, 22
BAR_WIDTH = 128


def _ranges(failed: FailedGate) -> Floats:
    """Return the least and greatest value of each velocity over the strip, (4, 2)."""
    values = failed.velocities()
    low, high = values.min(axis=0), values.max(axis=0)
    room = np.maximum(0.08 * (high - low), 0.05)
    return np.stack([low - room, high + room], axis=1)


def _picture(moment: Moment) -> str:
    if moment.image is None:
        return '<div class="no-frame">frame not recorded</div>'
    data = base64.b64encode(moment.image.read_bytes()).decode()
    return f'<img alt="camera frame" src="data:image/png;base64,{data}">'


def _dots(moment: Moment, ranges: Floats) -> str:
    """Return a small drawing: each member's prediction as a dot, the command as a line."""
    height = DOTS_ROW * len(VELOCITIES)
    parts = [f'<svg class="dots" viewBox="0 0 {DOTS_WIDTH} {height}" width="{DOTS_WIDTH}">']
    for index, (name, unit) in enumerate(zip(VELOCITIES, UNITS, strict=True)):
        low, high = ranges[index].tolist()
        y = index * DOTS_ROW + DOTS_ROW / 2

        def place(value: float, low: float = low, high: float = high) -> float:
            return 4 + (DOTS_WIDTH - 8) * (value - low) / (high - low)

        parts.append(f'<line class="rail" x1="4" x2="{DOTS_WIDTH - 4}" y1="{y}" y2="{y}"/>')
        for number, prediction in enumerate(moment.predictions[:, index].tolist()):
            chosen = " chosen" if number == moment.member[index] else ""
            tip = f"member {number}: {name} {prediction:+.2f} {unit}"
            parts.append(
                f'<circle class="dot{chosen}" cx="{place(prediction):.1f}" cy="{y}" r="3.2">'
                f"<title>{tip}</title></circle>"
            )
        x = place(float(moment.command[index]))
        parts.append(
            f'<line class="command" x1="{x:.1f}" x2="{x:.1f}" y1="{y - 7}" y2="{y + 7}">'
            f"<title>command: {name} {moment.command[index]:+.2f} {unit}</title></line>"
        )
    return "".join([*parts, "</svg>"])


def _bars(moment: Moment, longest: float) -> str:
    """Return the parts of the uncertainty as bars of the velocities' length."""
    bars = []
    for name, colour in PART_COLOURS.items():
        std = moment.std_m_s(name)
        width = BAR_WIDTH * std / longest if longest > 0 else 0
        bars.append(
            f'<div class="bar" title="{name} {std:.3f} m/s">'
            f'<span style="width:{width:.0f}px;background:{colour}"></span></div>'
        )
    return "".join(bars)


def _numbers(moment: Moment) -> str:
    command = " ".join(f"{value:+.2f}" for value in moment.command.tolist())
    if (moment.member == ALL_MEMBERS).all():
        chosen = "all members pooled"
    else:
        chosen = "member " + " ".join(str(member) for member in moment.member.tolist())
    modes = " ".join(str(count) for count in moment.modes.tolist())
    return f"<code>{command}</code><small>{chosen}<br>modes {modes}</small>"


def strip_html(failure: FailedGate) -> str:
    """Return the strip; a sentence where the log holds no decision before the failure."""
    text = escape(failure.event.text)
    if not failure.moments:
        return f"<p>{text}. The log holds no decisions of the seconds before.</p>"
    ranges = _ranges(failure)
    longest = failure.max_std_m_s()
    cells = [
        f'<figure class="moment"><figcaption>{-moment.before_s:.2f} s</figcaption>'
        f"{_picture(moment)}{_numbers(moment)}{_dots(moment, ranges)}{_bars(moment, longest)}"
        "</figure>"
        for moment in failure.moments
    ]
    keys = "".join(
        f'<span class="key"><i style="background:{colour}"></i>{name}</span>'
        for name, colour in PART_COLOURS.items()
    )
    return (
        f"<p><b>{text}</b>. Left to right, the last decisions before it: the camera's picture; "
        f"the command ({', '.join(VELOCITIES)}); each member's prediction as a dot, the chosen one "
        f"filled, the command as a line; and the parts of the uncertainty.</p>"
        f'<p class="keys">{keys}</p><div class="strip">{"".join(cells)}</div>'
    )
