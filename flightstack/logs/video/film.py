"""Write a film of a flight: MP4, H.264, each picture at the time of its image."""

from fractions import Fraction
from pathlib import Path
from typing import Any

from flightstack.libraries import load_library
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight
from flightstack.logs.seen import SeenImages, rate_hz
from flightstack.logs.video.picture import HEIGHT, SIDE, FilmPictures

CODEC, QUALITY = "libx264", "20"
MICROSECOND = Fraction(1, 1_000_000)


def write_film(flight: Flight, seen: SeenImages, output: Path) -> None:
    """Write the film; raises LogFileError where it cannot be written."""
    av = load_library("av", "video")
    try:
        container = av.open(str(output), "w", format="mp4")
    except (OSError, av.error.FFmpegError) as error:
        why = getattr(error, "strerror", None) or error
        raise LogFileError(f"{output} cannot be written: {why}; use -o") from error
    with container:
        stream = container.add_stream(CODEC, rate=rate_hz(seen.stamp_us), options={"crf": QUALITY})
        stream.width, stream.height, stream.pix_fmt = 2 * SIDE, HEIGHT, "yuv420p"
        stream.codec_context.time_base = MICROSECOND
        pictures = FilmPictures(flight, seen)
        for row, stamp_us in enumerate((seen.stamp_us - seen.stamp_us[0]).tolist()):
            picture = av.VideoFrame.from_ndarray(pictures.at(row), format="rgb24")
            picture.pts, picture.time_base = stamp_us, MICROSECOND
            _mux(container, stream, picture)
        _mux(container, stream, None)


def _mux(container: Any, stream: Any, picture: Any) -> None:
    for packet in stream.encode(picture):
        container.mux(packet)
