"""A vehicle whose movement another simulator makes: time and poses are told, one after the other.

Our world stands around it: gates that it can touch, though they do not stop it, the camera, and the
referee. A vehicle that starts anew finds the course as it was at first.
"""

from sitl.clock import TICK_S
from sitl.external.pose_link import PoseLink
from sitl.flown_vehicle import (
    BREAKAGE_STREAM,
    SimulationConfig,
    chance,
    feed_of_day,
    lay_out,
    look_of_day,
)
from sitl.records.course import CourseEvent, CourseStatus
from sitl.records.images import Image, ImageStamp
from sitl.records.motion import VehicleState
from sitl.sensors.camera.camera import Camera
from sitl.sensors.camera.feed import CameraFeed
from sitl.world.airframe import load_airframe
from sitl.world.referee import Referee
from sitl.world.world import World

AT_ORIGIN = VehicleState(
    0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
)


class FollowedVehicle:
    """One vehicle on a course, where its simulator says that it is."""

    def __init__(self, config: SimulationConfig, poses: PoseLink) -> None:
        """Build the world; raises UsageError where the track's noise cannot be."""
        self._config, self._poses = config, poses
        track = lay_out(config)
        standing = track.gates + track.decoys
        self._world = World(standing, load_airframe(config.airframe), tick_s=TICK_S, gui=config.gui)
        first = config.first_gate
        self.course_gates = track.gates[first:] + track.gates[:first]
        self._view = Camera(
            standing,
            look_of_day(config),
            field_of_view_deg=config.conditions.scenery.field_of_view_deg,
        )
        self._served = 0  # which of the vehicles
        self._events: list[CourseEvent] = []
        self._referee, self._camera = self._begin()
        self.state = AT_ORIGIN

    def close(self) -> None:
        """Free the physics engine and the renderer."""
        self._camera.close()
        self._world.close()

    @property
    def time_us(self) -> int:
        """Vehicle time: that of the pose, by its own clock."""
        return self.state.time_us

    def step(self) -> None:
        """Go on to the next pose; nothing happens where there is none."""
        pose = self._poses.take()
        if pose is None:
            return
        previous, self.state = self.state, pose
        if self._served != self._poses.connections:
            self._served = self._poses.connections
            self._referee, self._camera = self._begin()
            previous = pose
        contact = self._world.touches_gate_at(pose.position_ned, pose.q_ned_frd)
        self._events += self._referee.update(
            previous.position_ned, pose.position_ned, contact=contact
        )

    def image_due(self) -> bool:
        """Whether the camera gives an image out at this pose; true once for each."""
        return self._served > 0 and self._camera.is_due(self.state)

    @property
    def image_stamp(self) -> ImageStamp:
        """Time and number of the image that `render` gives."""
        return self._camera.stamp(self.time_us)

    def render(self) -> Image:
        """Give the image out that is due: one of this pose, unless the camera is late."""
        return self._camera.give(self.state)

    @property
    def course(self) -> CourseStatus:
        """The score so far."""
        return self._referee.status

    def drain_course_events(self) -> list[CourseEvent]:
        """Hand over what the referee saw since the last call."""
        events, self._events = self._events, []
        return events

    def _begin(self) -> tuple[Referee, CameraFeed]:
        """Give course and camera as they are before a flight."""
        config = self._config
        breakage_rng = chance(config, BREAKAGE_STREAM)
        camera = feed_of_day(config, self._view, failure_rng=breakage_rng)
        return Referee(self.course_gates, config.laps), camera
