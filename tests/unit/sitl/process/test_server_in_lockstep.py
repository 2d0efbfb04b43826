"""The loop around a simulation in lockstep: what it reads when, and when time passes."""

from collections.abc import Callable

import pytest

from sitl.clock import SECOND_US
from sitl.mavlink.wire.dialect import mavlink
from sitl.records.images import Image
from tests.unit.sitl.process.server_bench import Bench, Companion


def test_lockstep_stands_at_0_and_repeats_heartbeats(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(lockstep=True)
    stand, passes = bench.server._stand, 0

    def hurried_stand() -> None:
        nonlocal passes
        passes += 1
        bench.clock.now_s += 0.5
        if passes == 9:
            bench.server.stop()
        stand()

    bench.server._stand = hurried_stand  # type: ignore[method-assign]
    real_wait = bench.server._selector.select
    bench.server._selector.select = lambda _=None: real_wait(0.0)  # type: ignore[method-assign, assignment]
    bench.server.run()
    assert bench.simulation.time_us == 0
    heartbeat = mavlink.MAVLINK_MSG_ID_HEARTBEAT
    beats = [item.component for item in bench.arrived() if item.message_id == heartbeat]
    assert beats == [1, 100, 25] * (len(beats) // 3)
    assert 4 <= len(beats) // 3 <= 6


def test_lockstep_reads_nothing_between_an_answer_and_the_next_frame(
    make_bench: Callable[..., Bench],
) -> None:
    bench = make_bench(lockstep=True)
    companion = Companion(bench.stream, bench.link, bench.udp)
    handled = bench.note_commands()
    publish = bench.stream.publish

    def look(image: Image) -> None:
        publish(image)
        companion.command(1000 + image.sequence)
        companion.answer(image.time_us)
        companion.command(2000 + image.sequence)

    bench.stream.publish = look  # type: ignore[method-assign]
    bench.stop_at(200_000)
    bench.server.run()
    companion.tcp.close()
    # A command before the answer is handled at its image, one after it only at the next.
    assert handled[:5] == [(0, 1000), (52_000, 2000), (52_000, 1001), (100_000, 2001),
                           (100_000, 1002)]  # fmt: skip


def test_lockstep_can_be_stopped_where_no_image_comes(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(lockstep=True)
    companion = Companion(bench.stream, bench.link, bench.udp)
    companion.answer(0)
    bench.simulation.image_due = lambda: False  # type: ignore[method-assign]
    bench.stop_at(512_000)
    bench.server.run()
    assert bench.simulation.time_us == 512_000
    companion.tcp.close()


@pytest.mark.parametrize("speed_factor", [0.0, 1000.0])
def test_lockstep_listens_where_images_stay_out(
    make_bench: Callable[..., Bench], speed_factor: float
) -> None:
    """A camera that fails must not make the vehicle deaf: it could never be told to land."""
    bench = make_bench(lockstep=True, speed_factor=speed_factor)
    companion = Companion(bench.stream, bench.link, bench.udp)
    handled = bench.note_commands()
    companion.answer(0)
    companion.command(1000)
    bench.simulation.image_due = lambda: bench.simulation.time_us == 0  # type: ignore[method-assign]
    bench.stop_at(2 * SECOND_US)
    bench.server.run()
    companion.tcp.close()
    assert len(handled) == 1
    assert 1.5 * SECOND_US < handled[0][0] < 1.7 * SECOND_US


def test_lockstep_reads_nothing_while_images_stay_out_for_a_moment(
    make_bench: Callable[..., Bench],
) -> None:
    """A camera that fails intermittently is gone for a second, and an image's time about it."""
    bench = make_bench(lockstep=True)
    companion = Companion(bench.stream, bench.link, bench.udp)
    handled = bench.note_commands()
    companion.answer(0)
    companion.command(1000)
    due = iter((0, 1_052_000))
    next_us = next(due)

    def image_due() -> bool:
        nonlocal next_us
        is_due = bench.simulation.time_us == next_us
        next_us = next(due, next_us) if is_due else next_us
        return is_due

    bench.simulation.image_due = image_due  # type: ignore[method-assign]
    stand = bench.server._stand

    def last_stand() -> None:
        stand()
        if handled:
            bench.server.stop()

    bench.server._stand = last_stand  # type: ignore[method-assign]
    bench.server.run()
    companion.tcp.close()
    assert handled == [(1_052_000, 1000)]


def test_lockstep_runs_free_when_the_viewer_leaves(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(lockstep=True, speed_factor=1000.0)
    companion = Companion(bench.stream, bench.link, bench.udp)
    publish = bench.stream.publish

    def look(image: Image) -> None:
        publish(image)
        if image.sequence < 3:
            companion.answer(image.time_us)
        elif image.sequence == 3:
            companion.tcp.close()

    bench.stream.publish = look  # type: ignore[method-assign]
    bench.stop_at(SECOND_US)
    bench.server.run()
    assert bench.simulation.time_us == SECOND_US
