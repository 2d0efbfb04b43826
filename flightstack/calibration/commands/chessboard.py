"""Make a --camera-info file from a recording of a chessboard."""

import argparse

from flightstack.calibration.chessboard import calibrate
from flightstack.calibration.recordings import read_recording
from flightstack.camera.lens.camera_info import write_camera_info
from flightstack.camera.lens.network_view import NetworkView
from flightstack.errors import UsageError

MIN_CORNERS = 3
WIDE_SPREAD = 0.7  # of the image: farther out, the lens is a guess


def run(options: argparse.Namespace) -> str:
    """Calibrate and write the file; return what there is to say."""
    if min(options.columns, options.rows) < MIN_CORNERS:
        raise UsageError(f"--columns and --rows: at least {MIN_CORNERS} inner corners each")
    images = read_recording(options.recording)
    fit = calibrate(images, options.columns, options.rows, options.lens)
    info = fit.info
    remark = f"{fit.boards} boards, {fit.error_px:.2f} pixels of error"
    write_camera_info(options.output, info, remark)
    across, down = (round(100 * share) for share in fit.spread)
    lines = [
        f"{options.output}: {info.model} lens of {info.width_px} x {info.height_px} pixels, "
        f"{remark} (board seen in {fit.seen} images)",
        f"boards covered {across} % of the width and {down} % of the height; the lens shows "
        f"{100 * NetworkView(info).covered_share:.0f} % of the networks' 90 x 90 degrees",
    ]
    if min(fit.spread) < WIDE_SPREAD:
        lines.append("show the board closer to the edges: what lies beyond it is a guess")
    return "\n".join(lines)
