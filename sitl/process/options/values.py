"""Read the values of the command line, each from its text, or say what would do.

They raise argparse.ArgumentTypeError, which names the value and what is allowed.
"""

import argparse
import math

from sitl.records.motion import Vector3

LOOPBACK = "127.0.0.1"
MAX_INSTANCE = 249  # MAV_SYS_ID ends at 250
MIN_READY_S, MAX_READY_S = 1.0, 3600.0  # sensors have spoken then

Address = tuple[str, int]  # host, port


def numbers(text: str, count: int, example: str) -> list[float]:
    """Read so many numbers, separated by commas."""
    try:
        numbers = [float(piece) for piece in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise argparse.ArgumentTypeError(f"must be {count} numbers like {example}, got '{text}'")
    return numbers


def noise(text: str) -> tuple[float, float]:
    """Read GRN,GHN in m."""
    radius_m, height_m = numbers(text, 2, "1.0,2.0")
    if min(radius_m, height_m) < 0.0:
        raise argparse.ArgumentTypeError(f"must not be negative, got '{text}'")
    return radius_m, height_m


def home(text: str) -> Vector3:
    """Read LAT,LON,ALT in deg, deg, m AMSL."""
    latitude, longitude, altitude = numbers(text, 3, "47.397742,8.545594,489.4")
    if abs(latitude) > 89.0 or abs(longitude) > 180.0 or not -500.0 <= altitude <= 10_000.0:
        raise argparse.ArgumentTypeError(
            "latitude must be -89 to 89, longitude -180 to 180, altitude -500 to 10000, "
            f"got '{text}'"
        )
    return latitude, longitude, altitude


def speed(text: str) -> float:
    """Read a speed factor."""
    (factor,) = numbers(text, 1, "1.0")
    if not (factor == 0.0 or 0.01 <= factor <= 1000.0):
        raise argparse.ArgumentTypeError(f"must be 0 or 0.01 to 1000, got '{text}'")
    return factor


def ready(text: str) -> float:
    """Read after how many seconds a vehicle is ready."""
    (seconds,) = numbers(text, 1, "4.0")
    if not MIN_READY_S <= seconds <= MAX_READY_S:
        raise argparse.ArgumentTypeError(
            f"must be {MIN_READY_S:g} to {MAX_READY_S:g}, got '{text}'"
        )
    return seconds


def integer(text: str, low: int, high: int) -> int:
    """Read a whole number of a range."""
    try:
        number = int(text)
    except ValueError:
        number = low - 1
    if not low <= number <= high:
        raise argparse.ArgumentTypeError(f"must be a whole number {low} to {high}, got '{text}'")
    return number


def seed(text: str) -> int:
    """Read a seed."""
    return integer(text, 0, 2**63 - 1)


def laps(text: str) -> int:
    """Read a number of laps."""
    return integer(text, 1, 1000)


def instance(text: str) -> int:
    """Read the number of a vehicle."""
    return integer(text, 0, MAX_INSTANCE)


def port(text: str) -> int:
    """Read a port; 0: any free one."""
    return integer(text, 0, 65535)


def ports(text: str) -> tuple[int, int]:
    """Read LOCAL:REMOTE."""
    local, colon, remote = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"must be LOCAL:REMOTE like 18570:14550, got '{text}'")
    return port(local), port(remote)


def address(text: str) -> Address:
    """Read HOST:PORT."""
    host, colon, number = text.rpartition(":")
    if not colon or not host:
        raise argparse.ArgumentTypeError(f"must be HOST:PORT like {LOOPBACK}:14550, got '{text}'")
    return host, integer(number, 1, 65535)


def listening_address(text: str) -> Address:
    """Read PORT, on the loopback interface, or HOST:PORT."""
    host, _, number = text.rpartition(":")
    return host or LOOPBACK, port(number)


def video_address(text: str) -> Address:
    """Read udp://HOST:PORT."""
    scheme, separator, rest = text.partition("://")
    if not separator or scheme != "udp":
        raise argparse.ArgumentTypeError(f"must be like udp://{LOOPBACK}:5600, got '{text}'")
    return address(rest)
