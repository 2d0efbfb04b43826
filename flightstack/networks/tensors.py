"""The tensors that recur between the networks, by shape: B of a batch, Z latent dimensions."""

from jaxtyping import Float
from torch import Tensor

ImageTensor = Float[Tensor, "B 3 64 64"]  # in [-1, 1]
MapTensor = Float[Tensor, "B C H W"]
HalvedMaps = Float[Tensor, "B c h w"]  # with half the height and width
FeatureTensor = Float[Tensor, "B 512"]
LatentTensor = Float[Tensor, "B Z"]
Alike = Float[Tensor, "*alike"]  # any shape, the same for all that are called so
