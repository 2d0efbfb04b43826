"""The loop around a simulation, paced by the wall clock."""

from collections.abc import Callable
from typing import Any

import pytest

from sitl.clock import SECOND_US
from sitl.records.images import Image
from tests.unit.sitl.process.server_bench import Bench, Companion


def test_real_time_keeps_pace_with_the_wall_clock(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(speed_factor=2.0)
    bench.stop_at(SECOND_US // 5)
    real_wait = bench.server._selector.select

    def select(timeout_s: float | None = None) -> Any:
        bench.clock.now_s += timeout_s or 0.0  # the wait that the loop asks for
        return real_wait(0.0)

    bench.server._selector.select = select  # type: ignore[method-assign, assignment]
    bench.server.run()
    assert bench.clock.now_s == pytest.approx(0.1, abs=0.02)


def test_as_fast_as_possible_does_not_wait(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench()
    bench.stop_at(SECOND_US)
    bench.server.run()
    assert bench.simulation.time_us == SECOND_US


@pytest.mark.parametrize("lockstep", [False, True])
def test_telemetry_and_trigger_leave_before_the_image_is_drawn(
    make_bench: Callable[..., Bench], *, lockstep: bool
) -> None:
    bench = make_bench(lockstep=lockstep)
    order: list[str] = []
    render, publish = bench.simulation.render, bench.stream.publish

    def note() -> Image:
        order.extend(message.get_type() for message in bench.received())
        image = render()
        order.append(f"image {image.time_us}")
        return image

    bench.simulation.render = note  # type: ignore[method-assign]
    companion = Companion(bench.stream, bench.link, bench.udp) if lockstep else None

    def answered(image: Image) -> None:
        publish(image)
        if companion is not None:
            companion.answer(image.time_us)

    bench.stream.publish = answered  # type: ignore[method-assign]
    bench.stop_at(60_000)
    bench.server.run()
    if companion is not None:
        companion.tcp.close()
    for time_us in (0, 52_000):
        place = order.index(f"image {time_us}")
        assert order[place - 1] == "CAMERA_TRIGGER"
        assert "ATTITUDE" in order[:place]
    between = order[order.index("image 0") : order.index("image 52000")]
    assert between.count("ATTITUDE") == 5  # 100 Hz: the ticks at 12, 20, 32, 40 and 52 ms
