"""Say when the vehicle is to stand still in the air, why, and until when."""

from flightstack.companion.mission.records import Hold, Outcome, Situation

IMAGE_LATE_US = 500_000
CAMERA_LOST_US = 2_000_000


def hold_for_camera(image_us: int, now_us: int) -> Hold | None:
    """Return the hold that a camera calls for whose newest image is of `image_us`."""
    since_us = image_us + IMAGE_LATE_US
    if now_us < since_us:
        return None
    return Hold(reason=Outcome.CAMERA_LOST, since_us=since_us, lands_after_us=CAMERA_LOST_US)


def choose_hold(situation: Situation, now_us: int) -> Hold | None:
    """Return the hold that counts: of several, the one that lands first."""
    camera, other = hold_for_camera(situation.image_us, now_us), situation.hold
    if camera is None or other is None:
        return camera or other
    return min(camera, other, key=lambda hold: hold.lands_us)
