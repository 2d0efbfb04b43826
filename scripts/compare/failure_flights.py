"""Scripts that inject every failure which a vehicle knows, in every way."""

from scripts.compare.pilot import Pilot, ScriptedFlight, local
from scripts.compare.words import change_mode, command, parameter

INJECT_FAILURE = 420
UNITS = {"gyro": 0, "accelerometer": 1, "magnetometer": 2, "barometer": 3, "gps": 4}
CAMERA, BATTERY, MOTOR = 6, 100, 101
OK, OFF = 0, 1
KINDS = {
    "off": OFF,
    "stuck": 2,
    "garbage": 3,
    "wrong": 4,
    "slow": 5,
    "delayed": 6,
    "intermittent": 7,
}
SOON = {"COM_FAIL_ACT_T": 2.0, "RTL_RETURN_ALT": 4.0, "RTL_DESCEND_ALT": 3.0}
MAY_FAIL = {"SYS_FAILURE_EN": 1}


def _fail(unit: int, *kinds: int, seconds: float, instance: float = 0.0) -> ScriptedFlight:
    """In offboard, fail in these ways one after the other, each mended again."""

    def script(pilot: Pilot) -> None:
        pilot.take_off()
        pilot.enter_offboard(local((0.5, 0.3, 0.0), 0.2))
        for kind in kinds:
            pilot.fly(seconds, command(INJECT_FAILURE, float(unit), float(kind), instance))
            pilot.fly(1.5, command(INJECT_FAILURE, float(unit), float(OK), instance))
            pilot.fly(0.5, change_mode(6))

    return ScriptedFlight(script, {**MAY_FAIL, **SOON})


def _fail_with_sticks(unit: int, *modes: int) -> ScriptedFlight:
    def script(pilot: Pilot) -> None:
        pilot.sticks = (0, 0, 500, 0)
        pilot.take_off()
        for mode in modes:
            pilot.fly(1.0, change_mode(mode))
            pilot.fly(7.0, command(INJECT_FAILURE, float(unit), float(OFF)))
            pilot.fly(2.0, command(INJECT_FAILURE, float(unit), float(OK)))

    return ScriptedFlight(script, {**MAY_FAIL, **SOON})


def _camera_off(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.enter_offboard(local((0.5, 0.0, 0.0)))
    pilot.fly(0.05, command(INJECT_FAILURE, float(CAMERA), float(OFF)))
    pilot.wait_without_images(pilot.time_s + 10.0)


def _refused_failures(pilot: Pilot) -> None:
    for unit, kind, instance in ((4, 1, 0), (5, 1, 0), (101, 1, 5), (6, 4, 0), (105, 2, 0)):
        pilot.fly(0.1, command(INJECT_FAILURE, float(unit), float(kind), float(instance)))
    pilot.fly(0.1, parameter("SYS_FAILURE_EN", 1))
    for unit, kind, instance in ((5, 1, 0), (101, 1, 5), (6, 4, 0), (105, 2, 0), (2, 1, 0)):
        pilot.fly(0.1, command(INJECT_FAILURE, float(unit), float(kind), float(instance)))
    pilot.take_off()


def _failures() -> dict[str, ScriptedFlight]:
    mild = {name: UNITS[name] for name in ("magnetometer", "barometer", "gps")}
    hard = {name: UNITS[name] for name in ("gyro", "accelerometer")} | {"motor": MOTOR}
    all_kinds = tuple(KINDS.values())
    camera_kinds = tuple(kind for name, kind in KINDS.items() if name not in ("off", "wrong"))
    return {
        **{f"fail-{name}": _fail(unit, *all_kinds, seconds=6.5) for name, unit in mild.items()},
        **{
            f"fail-{name}-{how}": _fail(unit, kind, seconds=2.0, instance=float(unit == MOTOR))
            for name, unit in hard.items()
            for how, kind in KINDS.items()
        },
        "fail-all-motors": _fail(MOTOR, OFF, seconds=1.0),
        "fail-battery": _fail(BATTERY, *all_kinds[1:], OFF, seconds=2.0),
        "fail-camera": _fail(CAMERA, *camera_kinds, seconds=3.0),
        "fail-camera-off": ScriptedFlight(_camera_off, MAY_FAIL),
        "fail-gps-with-sticks": _fail_with_sticks(UNITS["gps"], 3, 2),
        "fail-barometer-with-sticks": _fail_with_sticks(UNITS["barometer"], 2, 3),
        "fail-refused": ScriptedFlight(_refused_failures),
    }


FAILURE_FLIGHTS = _failures()
