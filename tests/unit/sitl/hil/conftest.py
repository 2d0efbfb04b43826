from collections.abc import Iterator

import pytest

from sitl.hil.connection import Px4Connection


@pytest.fixture
def connection() -> Iterator[Px4Connection]:
    connection = Px4Connection(("127.0.0.1", 0))
    yield connection
    connection.close()
