"""Read coded video from a network with as little waiting as can be, dated by its own stamps.

Needs PyAV, which is imported only where such a stream is opened. RTSP and MPEG transport streams
are FFmpeg's, which knows that a picture has ended when the next one begins: one period late.
"""

import threading
from typing import Any

from flightstack.camera.mailbox import Arrival
from flightstack.camera.source import CameraSource
from flightstack.camera.video.decoded import ImageDater, make_prompt
from flightstack.camera.video.rtp_source import READ_TIMEOUT_S, RtpSource, listen_for_rtp
from flightstack.clock import VehicleClock
from flightstack.libraries import load_library

SCHEMES = ("rtsp", "rtsps", "rtp", "udp")
OPTIONS = {
    "fflags": "nobuffer",
    "analyzeduration": "1500000",  # us: whole pictures are seldom further apart
    "max_delay": "50000",  # us that packets may be out of order
    "rtsp_flags": "prefer_tcp",
    # Whoever names the address: nothing in the stream may name another one.
    "protocol_whitelist": "udp,rtp,rtsp,tcp,tls,srtp",
    "format_whitelist": "mpegts,rtp,rtsp,sdp,h264,hevc,mjpeg",
}


class VideoSource:
    """One stream that has been opened by FFmpeg."""

    def __init__(self, uri: str, clock: VehicleClock, *, timeout_s: float) -> None:
        """Open a stream; raises OSError where there is none, MissingLibraryError without PyAV."""
        av = load_library("av", "video")
        self._clock = clock
        self._dater = ImageDater(clock)
        self._closed = threading.Event()
        try:
            self._container: Any = av.open(
                uri, options=OPTIONS, timeout=(timeout_s, READ_TIMEOUT_S)
            )
        except av.error.FFmpegError as error:
            raise OSError(0, error.strerror or str(error)) from error
        if not self._container.streams.video:
            self._container.close()
            raise OSError(0, "there is no video in it")
        self._stream = self._container.streams.video[0]
        make_prompt(av, self._stream.codec_context)
        self._frames = self._container.decode(self._stream)

    def read(self) -> Arrival:
        """Wait for the next image; raises OSError when there are no more."""
        frame = next(self._frames, None)
        received_s = self._clock.wall_s()
        if frame is None or self._closed.is_set():
            self._container.close()
            raise OSError(0, "the camera gives no more frames")
        stamp_s = None if frame.pts is None else float(frame.pts * self._stream.time_base)
        return self._dater.arrival(frame, stamp_s, received_s)

    def close(self) -> None:
        """End reading; a `read` that waits in another thread returns with an error, in time."""
        self._closed.set()


def open_video(uri: str, clock: VehicleClock, *, timeout_s: float) -> CameraSource:
    """Open rtsp://, or listen at udp:// and rtp:// for whichever of RTP and MPEG arrives."""
    load_library("av", "video")  # or say at once what is missing
    if uri.startswith(("udp:", "rtp:")):
        listener = listen_for_rtp(uri, timeout_s)
        if listener is not None:
            return RtpSource(listener, clock)
    return VideoSource(uri, clock, timeout_s=timeout_s)
