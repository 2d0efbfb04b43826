"""A lens with strong distortion flies as the pinhole does, once its calibration is given."""

from pathlib import Path

import pytest

from flightstack.camera.lens.camera_info import write_camera_info
from tests.flight.camera.past_proxy import fly_past
from tests.lenses import STRONG, Lens
from tests.wire.camera_proxy import of_pictures

pytestmark = pytest.mark.flight
SIDE_PX = 64  # of the simulator's images


def test_a_calibrated_lens_flies_the_course(tmp_path: Path) -> None:
    calibration = tmp_path / "camera.yaml"
    write_camera_info(calibration, STRONG, "the lens of this test")
    warp = of_pictures(Lens(STRONG, SIDE_PX))
    result, said, code, _ = fly_past(tmp_path, warp, f"--camera-info={calibration}")
    assert (result["outcome"], result["gates_passed"], code) == ("completed", 8, 0)
    assert "warning" not in said
