"""What the user says of his camera."""

from dataclasses import dataclass

from flightstack.camera.lens.network_view import NetworkView


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """How a camera is opened, and what is known of it; left out, it is taken as it comes."""

    view: NetworkView | None = None  # through its lens
    latency_s: float = 0.0  # from exposure to where an image without a stamp is dated
