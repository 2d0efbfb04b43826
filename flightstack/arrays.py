"""The arrays that recur, by type and shape: jaxtyping checks them where the tests ask it to.

One alphabet: N policies, M latent samples, Z latent dimensions, B of a batch, K of a dataset, S =
N M components of a mixture. 4 are the velocities (vx, vy, vz, yaw rate), or a gate's labels.
"""

import numpy as np
from jaxtyping import Float32, Float64, Int64, UInt8
from numpy.typing import NDArray

Rgb = UInt8[NDArray[np.uint8], "H W 3"]  # an image of any size
SmallRgb = UInt8[NDArray[np.uint8], "64 64 3"]  # an image as the networks see it
RgbStack = UInt8[NDArray[np.uint8], "K 64 64 3"]

Latents = Float32[NDArray[np.float32], "M Z"]

PerAxis = Float32[NDArray[np.float32], "3"]  # forward, right, down; or roll, pitch, yaw
PerVelocity = Float64[NDArray[np.float64], "4"]
CountPerVelocity = Int64[NDArray[np.int64], "4"]  # or the number of a member
PerMember = Float64[NDArray[np.float64], "N 4"]
PerSample = Float64[NDArray[np.float64], "N M 4"]

PerImage = Float64[NDArray[np.float64], "K 4"]
PerComponent = Float64[NDArray[np.float64], "S K 4"]
Labels = Float32[NDArray[np.float32], "K 4"]

PerGate = Float64[NDArray[np.float64], "K"]  # K gates seen in one image
GatePositions = Float64[NDArray[np.float64], "K 3"]
GateCovariances = Float64[NDArray[np.float64], "K 3 3"]
