"""The stamped stream, from a real socket."""

import pytest

from flightstack.camera.multipart import MultipartSource, NotMultipartError
from flightstack.camera.parts import decode_rgb
from flightstack.clock import VehicleClock
from tests.unit.flightstack.camera.made_stream import MadeStream, part, picture


def opened(stream: MadeStream, clock: VehicleClock | None = None) -> MultipartSource:
    return MultipartSource(stream.uri, clock or VehicleClock())


def test_images_come_with_stamp_number_and_colours() -> None:
    first = part(picture(200, 100, 50), X_Timestamp="12.052000", X_Sequence="241")
    second = part(picture(1, 2, 3), X_Timestamp="12.100000", X_Sequence="242")
    with MadeStream(first + second) as stream:
        source = opened(stream)
        arrivals = [source.read() for _ in range(2)]
        source.close()
    images = [arrival.image for arrival in arrivals]
    assert [(image.stamp_us, image.sequence) for image in images] == [
        (12_052_000, 241),
        (12_100_000, 242),
    ]
    assert images[0].rgb.shape == (64, 64, 3)
    assert images[0].rgb[5, 5].tolist() == [200, 100, 50]
    assert all(arrival.stamped for arrival in arrivals)
    assert stream.requests[0].startswith(b"GET /stream HTTP/1.1\r\n")


def test_images_may_come_in_pieces() -> None:
    whole = part(picture(9, 9, 9), X_Timestamp="1.0")
    with MadeStream(*(whole[at : at + 7] for at in range(0, len(whole), 7))) as stream:
        source = opened(stream)
        assert source.read().image.stamp_us == 1_000_000
        source.close()


def test_a_stream_without_stamps_is_stamped_on_arrival() -> None:
    clock = VehicleClock(lambda: 0.0)
    clock.observe(5_000_000)
    with MadeStream(part(picture(1, 1, 1), suffix=".jpg") * 2) as stream:
        source = opened(stream, clock)
        arrivals = [source.read() for _ in range(2)]
        source.close()
    assert [(each.image.stamp_us, each.image.sequence, each.stamped) for each in arrivals] == [
        (5_000_000, 1, False),
        (5_000_000, 2, False),
    ]


def test_a_damaged_image_is_passed_over() -> None:
    damaged = b"--b\r\nContent-Length: 4\r\nX-Timestamp: 1.0\r\n\r\nnope\r\n"
    with MadeStream(damaged + part(picture(1, 1, 1), X_Timestamp="2.0")) as stream:
        source = opened(stream)
        assert source.read().image.stamp_us == 2_000_000
        source.close()


@pytest.mark.parametrize(
    "content", [b"", b"--b\r\nContent-Length: 99\r\n\r\nshort", b"--b\r\nX-Sequence: 1\r\n\r\n"]
)
def test_a_stream_that_ends_says_so(content: bytes) -> None:
    with MadeStream(content, ends=True) as stream:
        source = opened(stream)
        with pytest.raises(OSError, match=r"ended|Content-Length"):
            source.read()
        source.close()


def test_something_else_than_a_stream_is_left_to_opencv() -> None:
    greeting = b"HTTP/1.1 200 OK\r\nContent-Type: video/mp4\r\nContent-Length: 0\r\n\r\n"
    with MadeStream(greeting=greeting) as stream, pytest.raises(NotMultipartError):
        opened(stream)


def test_a_refusal_is_told() -> None:
    greeting = b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"
    with MadeStream(greeting=greeting) as stream, pytest.raises(OSError, match="404 Not Found"):
        opened(stream)


def test_nonsense_does_not_decode() -> None:
    assert decode_rgb(b"") is None
    assert decode_rgb(b"nonsense") is None
