"""What holds for every test."""

import signal


def pytest_configure() -> None:
    """Let processes under test be interrupted: a shell ignores SIGINT for its background jobs."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
