"""What the user says of his camera."""

from dataclasses import dataclass

from flightstack.camera.lens.network_view import NetworkView


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceSettings:
    """What a video device (V4L2) is asked for; what is left out stays as the device has it."""

    size_px: tuple[int, int] | None = None  # width, height
    rate_hz: float | None = None
    exposure_s: float | None = None  # by hand; else the device's automatic stays

    @property
    def asks(self) -> bool:
        """Whether there is anything to ask for."""
        return self != DeviceSettings()


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """How a camera is opened, and what is known of it; left out, it is taken as it comes."""

    view: NetworkView | None = None  # through its lens
    device: DeviceSettings = DeviceSettings()
    latency_s: float = 0.0  # from exposure to where an image without a stamp is dated
