"""The gate detector, trained and ready: an image to a set of gates with uncertainties."""

import torch

from flightstack.arrays import SmallRgb
from flightstack.perception.gate_decoding import DetectionCalibration, decode
from flightstack.perception.gate_network import GateNetwork
from flightstack.perception.preprocessing import network_input
from flightstack.records import GateDetections


class GateDetector:
    """Detects gates, one image after another; a pure function of the image."""

    def __init__(self, network: GateNetwork, calibration: DetectionCalibration) -> None:
        """Take a trained network."""
        self._network = network.eval()
        self._calibration = calibration

    def detect(self, rgb: SmallRgb) -> GateDetections:
        """Return the gates in an image of 64 x 64 pixels."""
        with torch.inference_mode():
            cells = self._network(network_input(rgb[None]))[0].numpy()
        return decode(cells, self._calibration)
