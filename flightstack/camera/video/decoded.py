"""Turn a decoder's pictures into images, dated by the stream's own stamps."""

from typing import TYPE_CHECKING, Any

import numpy as np

from flightstack.camera.mailbox import Arrival
from flightstack.camera.picture_size import MAX_PIXELS
from flightstack.camera.stream_clock import StreamClock
from flightstack.clock import VehicleClock
from flightstack.records import Image

if TYPE_CHECKING:
    from av import VideoFrame


class ImageDater:
    """Number and date the pictures of one stream; for the thread that decodes."""

    def __init__(self, clock: VehicleClock) -> None:
        self._clock = clock
        self._stream_clock = StreamClock()
        self._count = 0

    def arrival(self, frame: "VideoFrame", stamp_s: float | None, received_s: float) -> Arrival:
        """Return an image; `stamp_s` is of the stream's own clock, where it tells one."""
        self._count += 1
        taken_s = None if stamp_s is None else self._stream_clock.left_s(stamp_s, received_s)
        image = Image(
            stamp_us=self._clock.at_us(received_s if taken_s is None else taken_s),
            sequence=self._count,
            rgb=np.ascontiguousarray(frame.to_ndarray(format="rgb24"), np.uint8),
        )
        return Arrival(image, received_s, stamped=False, taken_s=taken_s)


def make_prompt(av: Any, codec_context: Any) -> None:
    """Have a decoder give each picture at once, and none that is too large."""
    codec_context.thread_count = 1  # each further thread is a picture of delay
    codec_context.flags |= av.codec.context.Flags.low_delay
    codec_context.options = {"max_pixels": str(MAX_PIXELS)}
