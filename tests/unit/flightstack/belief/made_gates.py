"""Made-up sightings of gates, as a detector would tell them, for a vehicle anywhere."""

import math

import numpy as np

from flightstack.belief.mapping import rotation_of
from flightstack.records import GateDetections, Pose

Point = tuple[float, float, float]
STD_M = 0.1


def pose_at(
    position: Point = (0.0, 0.0, -3.0), yaw_rad: float = 0.0, time_us: int = 1_000_000
) -> Pose:
    return Pose(
        time_us=time_us,
        position_ned=position,
        velocity_ned=(0.0, 0.0, 0.0),
        roll_rad=0.05,
        pitch_rad=-0.1,
        yaw_rad=yaw_rad,
    )


def seen(
    gates: list[tuple[Point, float]], pose: Pose, *, score: float = 0.9, std_m: float = STD_M
) -> GateDetections:
    """Return gates (centre NED, heading) as they are seen from a pose, without errors."""
    offset = np.array([centre for centre, _ in gates]).reshape(-1, 3) - np.array(pose.position_ned)
    heading = np.array([axis - pose.yaw_rad for _, axis in gates])
    count = len(gates)
    return GateDetections(
        position_frd=offset @ rotation_of(pose),
        covariance_frd=np.repeat(std_m**2 * np.eye(3)[None], count, axis=0),
        heading_rad=np.mod(heading + math.pi / 2, math.pi) - math.pi / 2,
        heading_std_rad=np.full(count, 0.1),
        score=np.full(count, score),
    )
