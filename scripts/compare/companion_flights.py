"""The flights of a companion: on four courses, in each condition, through each of its phases."""

from collections.abc import Mapping

from scripts.compare.companion import CompanionFlight, Event
from scripts.compare.words import change_mode, command, parameter

SEEDS = range(4)
CONDITIONS = (  # a value that bites of each key of docs/conditions.md
    "wind.mean_ned_m_s=[4.0,-3.0,0.5]",
    "wind.gust_std_m_s=2.0",
    "wind.gust_time_constant_s=0.5",
    "light.fog_visibility_m=12.0",
    "light.daylight_share=0.1",
    "camera.latency_s=0.1",
    "camera.blur_std_px=2.0",
    "camera.noise_std_levels=30.0",
    "camera.frozen_frame_share=0.3",
    "course.decoy_inwards_m=2.4",
    "estimate.rotor_noise_share=1.0",
)
ALSO = {"wind.gust_time_constant_s=0.5": ("--condition=wind.gust_std_m_s=2.0",)}  # none without
SHORT = ("--duration=6",)
ARMS_S, CLIMBS_S, FLIES_S = 2.0, 5.0, 13.0  # vehicle time
ARM, INJECT_FAILURE = 400, 420
GPS, CAMERA, MOTOR, OFF, STUCK = 4.0, 6.0, 101.0, 1.0, 2.0
KILL = command(ARM, 0.0, 21196.0)
MAY_FAIL = (("SYS_FAILURE_EN", 1),)


def companion_flights() -> dict[str, CompanionFlight]:
    """Give all of them by name."""
    courses = {
        f"companion-course-{seed}": CompanionFlight(
            vehicle=(f"--track-seed={seed}", f"--seed={seed}", "--noise=1.0,2.0", "--laps=1"),
            companion=("--model=strong/m0", f"--seed={seed}", "--duration=90"),
        )
        for seed in SEEDS
    }
    conditions = {
        f"companion-{text.partition('=')[0]}": CompanionFlight(
            vehicle=(f"--condition={text}", *ALSO.get(text, ())), companion=SHORT
        )
        for text in CONDITIONS
    }
    return {**courses, **conditions, **_endings(), **_interventions()}


def _endings() -> Mapping[str, CompanionFlight]:
    """Ways of flying and of ending that options ask for."""
    return {
        "companion-paper-model": CompanionFlight(
            companion=("--model=paper/m0", "--duration=6", "--takeoff-altitude=2")
        ),
        "companion-counter-clockwise": CompanionFlight(
            vehicle=("--direction=ccw", "--track-seed=7", "--perfect-estimate"),
            companion=("--direction=ccw", "--speed-scale=1.3", *SHORT),
        ),
        "companion-gate-timeout": CompanionFlight(companion=("--gate-timeout=2", "--no-landing")),
        "companion-members": CompanionFlight(
            companion=("--record-frames", "--duration=4", "--no-landing")
        ),
        "companion-finds-it-airborne": CompanionFlight(
            events=(
                Event(0.5, (command(22, *[float("nan")] * 7),)),
                Event(1.2, (command(ARM, 1),)),
            ),
            companion=SHORT,
        ),
    }


def _interventions() -> Mapping[str, CompanionFlight]:
    """Things that others do, or that fail, in each phase."""
    happening = {
        "companion-unarmable-mode": (Event(0.3, (change_mode(4, 5),)),),
        "companion-arming-refused": (Event(ARMS_S, (change_mode(4, 5),)),),
        "companion-stopped-on-ground": (Event(1.0, stops_companion=True),),
        "companion-stopped-in-climb": (Event(CLIMBS_S, stops_companion=True),),
        "companion-stopped-in-flight": (Event(FLIES_S, stops_companion=True),),
        "companion-taken-over-in-climb": (Event(CLIMBS_S, (change_mode(4, 6),)),),
        "companion-taken-over-in-flight": (Event(FLIES_S, (change_mode(4, 3),)),),
        "companion-given-back": (
            Event(FLIES_S, (change_mode(4, 3),)),
            Event(FLIES_S + 2.0, (change_mode(6, 0),)),
        ),
        "companion-killed-vehicle": (Event(FLIES_S, (KILL,)),),
        "companion-low-battery": (
            Event(FLIES_S, (parameter("SIM_BAT_MIN_PCT", 0.0), parameter("SIM_BAT_DRAIN", 3.0))),
        ),
        "companion-without-gps": (Event(FLIES_S, (command(INJECT_FAILURE, GPS, OFF),)),),
        "companion-stuck-camera": (Event(FLIES_S, (command(INJECT_FAILURE, CAMERA, STUCK),)),),
        "companion-lost-motor": (Event(FLIES_S, (command(INJECT_FAILURE, MOTOR, OFF, 1.0),)),),
    }
    return {
        name: CompanionFlight(events=events, companion=("--duration=9",), parameters=MAY_FAIL)
        for name, events in happening.items()
    }
