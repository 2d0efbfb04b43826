"""What holds for every test."""

import signal

from hypothesis import settings

from tests import shape_checks

settings.register_profile("house", deadline=None)  # no test depends on how busy a machine is
settings.load_profile("house")
shape_checks.install()  # before a test imports what is to be checked; every worker comes by here


def pytest_configure() -> None:
    """Let processes under test be interrupted: a shell ignores SIGINT for its background jobs."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
