"""What the tests of links share."""

from collections.abc import Iterator

import pytest

from tests.unit.sitl.mavlink.bench import Bench


@pytest.fixture
def bench() -> Iterator[Bench]:
    """A vehicle with both links, and a client at each."""
    bench = Bench()
    yield bench
    bench.close()
