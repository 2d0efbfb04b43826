"""Every kind of fault that a flight is tried with."""

import os
import signal
import time
from dataclasses import replace

from scripts.bench.faults.flights import (
    STATION_PORT,
    Fault,
    Scene,
    end,
    pause,
    start_again,
    worker_of,
)
from scripts.bench.faults.relays import Weather

PART_KINDS = {
    "raises": "Raises",
    "raises for one image": "RaisesOnce",
    "calls sys.exit()": "Exits",
    "crashes": "Dies",
    "hangs": "Hangs",
    "leaks 25 MB an image": "Leaks",
    "takes 0.3 s": "IsSlow",
    "gives NaN": "GivesNan",
    "gives three numbers": "GivesThree",
}
PAUSE_S = 5.0


def _touch(scene: Scene) -> None:
    scene.trigger.touch()


def _kill_worker(scene: Scene) -> None:
    worker = worker_of(scene.companion)
    if worker is not None:
        os.kill(worker, signal.SIGKILL)


def _camera(fault: str) -> Fault:
    def begin(scene: Scene) -> None:
        scene.camera.fault = fault

    return Fault(name=f"camera {fault}", begin=begin)


def outage(seconds: float) -> Fault:
    """Return a link that carries nothing for a while."""

    def begin(scene: Scene) -> None:
        scene.link.weather = Weather(out_until_s=time.monotonic() + seconds)

    return Fault(name=f"link out for {seconds:g} s", begin=begin)


def bad_link(name: str, weather: Weather) -> Fault:
    """Return a link that is bad from then on."""

    def begin(scene: Scene) -> None:
        scene.link.weather = replace(weather)

    return Fault(name=name, begin=begin)


def _kill_vehicle(scene: Scene) -> None:
    end(scene.vehicle)


def _restart_vehicle(scene: Scene) -> None:
    command = list(map(str, scene.vehicle.args))[3:]  # type: ignore[arg-type]
    end(scene.vehicle)
    scene.vehicle = scene.start("sitl", *command, output="vehicle.txt")


def _restart_companion(scene: Scene) -> None:
    end(scene.companion)
    start_again(scene)


def _second_companion(scene: Scene) -> None:
    station = f"--connect=udpout:127.0.0.1:{STATION_PORT + scene.instance}"
    log = f"--log={scene.folder / 'second.tlog'}"
    other = scene.start(
        "flightstack.companion", station, log, "--json", "--duration=12", output="second.txt"
    )
    scene.others.append(other)


LOSSES = {
    **{f"{share}% loss each way": Weather(loss=share / 100) for share in (5, 10, 20, 30)},
    "200 ms delay, 50 ms jitter": Weather(delay_s=0.2, jitter_s=0.05),
    "500 ms delay, 100 ms jitter": Weather(delay_s=0.5, jitter_s=0.1),
    "every fifth twice": Weather(copies=0.2),
    "reordered (30 ms)": Weather(jitter_s=0.03),
}
OUTAGES_S = (0.5, 2.0, 4.0, 10.0)
KILLS = (
    Fault(name="companion killed", begin=lambda s: end(s.companion), companion_survives=False),
    Fault(name="vehicle killed", begin=_kill_vehicle, vehicle_survives=False),
)
STOPS = (
    Fault(name="companion stopped for 5 s", begin=lambda s: pause(s.companion, PAUSE_S)),
    Fault(name="vehicle stopped for 5 s", begin=lambda s: pause(s.vehicle, PAUSE_S)),
)
FAULTS = (
    Fault(name="none", begin=lambda _: None),
    *(
        Fault(name=f"strategy {name}", begin=_touch, companion=(f"--strategy=parts:{part}",))
        for name, part in PART_KINDS.items()
    ),
    Fault(name="worker killed", begin=_kill_worker, companion=("--strategy=parts:Raises",)),
    *(_camera(fault) for fault in ("stalls", "breaks", "is gone", "freezes")),
    *KILLS,
    *STOPS,
    Fault(name="vehicle restarts", begin=_restart_vehicle),
    Fault(name="companion killed, started again", begin=_restart_companion),
    Fault(name="SIGINT", begin=lambda s: s.companion.send_signal(signal.SIGINT)),
    Fault(name="second companion", begin=_second_companion),
)
LINKS = (
    *(bad_link(name, weather) for name, weather in LOSSES.items()),
    *(outage(seconds) for seconds in OUTAGES_S),
)
