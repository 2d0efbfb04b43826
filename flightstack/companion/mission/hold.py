"""Say when the vehicle is to stand still in the air, why, and until when."""

from flightstack.companion.mission.records import Hold, Outcome, Situation

IMAGE_LATE_US = 500_000
CAMERA_LOST_US = 2_000_000
PART_FAILED_US = 2_000_000
OUTSIDE_US = 2_000_000
ERROR_US = 1_000_000
CAMERA_LIES_US = 5_000_000  # more than the other: images that come may come right


def hold_for_camera(image_us: int, now_us: int) -> Hold | None:
    """Return the hold that a camera calls for whose newest image is of `image_us`."""
    since_us = image_us + IMAGE_LATE_US
    if now_us < since_us:
        return None
    return Hold(reason=Outcome.CAMERA_LOST, since_us=since_us, lands_after_us=CAMERA_LOST_US)


def hold_for_part(now_us: int) -> Hold:
    """Return the hold that a part of the pilot calls for which has just failed."""
    return Hold(reason=Outcome.PART_FAILED, since_us=now_us, lands_after_us=PART_FAILED_US)


def hold_for_late_part(decided_us: int, now_us: int) -> Hold | None:
    """Return the hold that a pilot calls for whose newest decision is for an image this old."""
    since_us = decided_us + IMAGE_LATE_US
    if now_us < since_us:
        return None
    return Hold(reason=Outcome.PART_FAILED, since_us=since_us, lands_after_us=PART_FAILED_US)


def hold_outside(now_us: int) -> Hold:
    """Return the hold that a vehicle calls for which is outside its limits."""
    return Hold(reason=Outcome.OUT_OF_LIMITS, since_us=now_us, lands_after_us=OUTSIDE_US)


def hold_for_error(now_us: int) -> Hold:
    """Return the hold that an error of our own calls for."""
    return Hold(reason=Outcome.COMPANION_FAILED, since_us=now_us, lands_after_us=ERROR_US)


def choose_hold(situation: Situation, now_us: int) -> Hold | None:
    """Return the hold that counts: of several, the one that lands first."""
    camera, lies_us = hold_for_camera(situation.image_us, now_us), situation.camera_lies_us
    lying = (
        None
        if lies_us is None
        else Hold(reason=Outcome.CAMERA_LOST, since_us=lies_us, lands_after_us=CAMERA_LIES_US)
    )
    holds = [hold for hold in (camera, lying, *situation.holds) if hold is not None]
    return min(holds, key=lambda hold: hold.lands_us, default=None)
