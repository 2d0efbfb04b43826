"""What the tests that fly with MAVSDK share."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from mavsdk import System

from tests.flight.clients.mavsdk_vehicle import found_vehicle


@pytest.fixture
def system(tmp_path: Path) -> Iterator[System]:
    """Hand out a vehicle that MAVSDK has found."""
    with found_vehicle(tmp_path) as found:
        yield found
