"""Send the camera as video for ground stations: H.264 over RTP, as they expect it on UDP port 5600.

The stamps are vehicle time. Every second begins with a whole picture, so that a ground station may
join at any time. Needs PyAV, which is imported only where video is asked for.
"""

import socket
from contextlib import suppress
from fractions import Fraction
from typing import TYPE_CHECKING, cast

import numpy as np

from sitl.errors import LinkError
from sitl.process.installed import require
from sitl.process.options.values import Address
from sitl.records.images import Image

if TYPE_CHECKING:
    from av import VideoStream
    from av.container import OutputContainer

CODEC = "libx264"
ENLARGED = 4  # times: ground stations show small pictures badly
MICROSECOND = Fraction(1, 1_000_000)
PACKET_BYTES = 1200  # below any usual network's limit


class VideoSender:
    """One stream to one address; whether anybody looks is not known."""

    def __init__(self, address: Address, *, size_px: int, rate_hz: int) -> None:
        """Prepare to send square pictures of `size_px`.

        Raises:
            UsageError: PyAV is not there.
            LinkError: there is no such host, or no way there.

        """
        require("av", "video", "--video")
        import av  # noqa: PLC0415  an extra

        self._av = av
        try:
            local, remote = _way_to(address)
            # Bound to the one interface that leads there: it opens nothing on the others.
            url = f"rtp://{remote}:{address[1]}?pkt_size={PACKET_BYTES}&localaddr={local}"
            self._container: OutputContainer = av.open(url, "w", format="rtp")
        except OSError as error:
            why = error.strerror or error
            raise LinkError(f"--video udp://{address[0]}:{address[1]}: {why}") from None
        options = {"preset": "ultrafast", "tune": "zerolatency", "profile": "baseline"}
        stream = self._container.add_stream(CODEC, rate=rate_hz, options=options)
        self._stream = cast("VideoStream", stream)
        self._stream.width = self._stream.height = size_px * ENLARGED
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = MICROSECOND
        self._stream.codec_context.gop_size = rate_hz

    def publish(self, image: Image) -> None:
        """Send one picture; it is lost if nobody is there."""
        enlarged = np.repeat(np.repeat(image.rgb, ENLARGED, axis=0), ENLARGED, axis=1)
        picture = self._av.VideoFrame.from_ndarray(enlarged, format="rgb24")
        picture.pts, picture.time_base = image.time_us, MICROSECOND
        for packet in self._stream.encode(picture):
            with suppress(OSError):
                self._container.mux(packet)

    def close(self) -> None:
        """End the stream."""
        with suppress(OSError):
            self._container.close()


def _way_to(address: Address) -> tuple[str, str]:
    """Give the numeric addresses of this end and of that one; raises OSError."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(address)  # sends nothing
        return probe.getsockname()[0], probe.getpeername()[0]
