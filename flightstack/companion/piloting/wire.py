"""Write images and decisions as bytes, and read them: what a worker process is told, and tells.

An image goes with the pose of its moment, where telemetry tells one. Of a decision all numbers are
float64: command, the three standard deviations, member, number of modes (four each), then score and
member mean (N x 4 each). The first byte of a message of the worker says what it is.
"""

import struct

import numpy as np

from flightstack.records import VELOCITIES, Decision, Image, Pose

LOADED, READY, DECIDED, FAILED, REFUSED = b"L", b"R", b"D", b"F", b"X"
WIDTH = len(VELOCITIES)
IMAGE = struct.Struct("<qqHH?q9d")  # stamp (us), sequence, height, width; the pose; then RGB bytes
NO_POSE = (False, 0, *(0.0,) * 9)
FIXED = 6  # rows that do not depend on N


def write_image(image: Image, pose: Pose | None) -> bytes:
    """Return the bytes of an image and of where the vehicle was."""
    height, width, _ = image.rgb.shape
    told = NO_POSE
    if pose is not None:
        angles = (pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
        told = (True, pose.time_us, *pose.position_ned, *pose.velocity_ned, *angles)
    head = IMAGE.pack(image.stamp_us, image.sequence, height, width, *told)
    return head + image.rgb.tobytes()


def read_image(data: bytes) -> tuple[Image, Pose | None]:
    """Return what the bytes tell of."""
    stamp_us, sequence, height, width, has_pose, time_us, *told = IMAGE.unpack_from(data)
    rgb = np.frombuffer(data, np.uint8, offset=IMAGE.size).reshape(height, width, 3)
    image = Image(stamp_us=stamp_us, sequence=sequence, rgb=rgb.copy())
    if not has_pose:
        return image, None
    north, east, down, v_north, v_east, v_down, roll, pitch, yaw = told
    return image, Pose(
        time_us=time_us,
        position_ned=(north, east, down),
        velocity_ned=(v_north, v_east, v_down),
        roll_rad=roll,
        pitch_rad=pitch,
        yaw_rad=yaw,
    )


def write_decision(decision: Decision) -> bytes:
    """Return the bytes of a decision."""
    rows = (
        decision.command,
        decision.aleatoric_std,
        decision.epistemic_std,
        decision.perceptual_std,
        decision.member,
        decision.modes,
        decision.score,
        decision.member_mean,
    )
    return np.concatenate(rows, axis=None, dtype=np.float64).tobytes()


def read_decision(data: bytes) -> Decision:
    """Return the decision that the bytes tell of; raises ValueError where they tell of none."""
    rows = np.frombuffer(data, np.float64).reshape(-1, WIDTH)
    members = (len(rows) - FIXED) // 2
    return Decision(
        command=rows[0],
        aleatoric_std=rows[1],
        epistemic_std=rows[2],
        perceptual_std=rows[3],
        member=rows[4].astype(np.int64),
        modes=rows[5].astype(np.int64),
        score=rows[FIXED : FIXED + members],
        member_mean=rows[FIXED + members :],
    )
