"""Export trained networks to their flight form, and hold the two against each other on images.

Dropout masks and noise are inputs of the graphs, and the shapes of images are fixed; how many
passes and samples there are is left open.
"""

import logging
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnx
import torch
from jaxtyping import Float, UInt8
from torch import Tensor, nn

from flightstack.arrays import Latents, RgbStack
from flightstack.errors import ModelError
from flightstack.gate_models import DetectorFlightForm
from flightstack.inference.graph import Graph, Signature
from flightstack.models import FlightForm, file_sha256
from flightstack.networks.dronet import Dronet, dropout_mask
from flightstack.networks.gate_network import GateNetwork
from flightstack.networks.images import WHITE, network_input
from flightstack.networks.policy_stack import PolicyStack
from flightstack.networks.trained import TrainedModel
from flightstack.perception.config import FEATURES
from flightstack.perception.encoder import ENCODER_FILE, encoder_signature
from flightstack.perception.gate_detector import DETECTOR_FILE, DETECTOR_SIGNATURE
from flightstack.policy.networks import POLICIES_FILE, policies_signature

MAX_DIFFERENCE = 1e-4  # network units, of any output on any image
OPSET = 20  # of ONNX, 2023: ONNX Runtime 1.17 and later read it
TRACED = 32  # passes and samples of the example that is traced
SEED = 0  # of the masks and the noise by which the two are compared


class FlightEncoder(nn.Module):
    """Bytes, masks and noise to latent samples, and their mean and log-variance."""

    def __init__(self, encoder: Dronet) -> None:
        super().__init__()
        self.encoder = encoder

    def forward(
        self,
        rgb: UInt8[Tensor, "1 64 64 3"],
        masks: Float[Tensor, "P 512"],
        noise: Float[Tensor, "M Z"],
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Pass one image through, its features under each mask."""
        features = self.encoder.trunk(_scaled(rgb))
        mean, logvar = self.encoder.head(features * masks)
        return mean + noise * torch.exp(0.5 * logvar), mean, logvar


class FlightPolicies(nn.Module):
    """Latents to means and variances."""

    def __init__(self, policies: PolicyStack) -> None:
        super().__init__()
        self.policies = policies

    def forward(self, z: Float[Tensor, "M Z"]) -> tuple[Tensor, Tensor]:
        """Pass latents through every member."""
        mean, logvar = self.policies(z)
        return mean, torch.exp(logvar)


class FlightDetector(nn.Module):
    """Bytes to cells."""

    def __init__(self, network: GateNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, rgb: UInt8[Tensor, "1 64 64 3"]) -> Tensor:
        """Pass one image through."""
        cells: Tensor = self.network(_scaled(rgb))
        return cells


def export_model(folder: Path, model: TrainedModel, images: RgbStack) -> FlightForm:
    """Write a model's graphs into its folder, and return their hashes.

    Raises ModelError where a graph says anything else than its networks on one of the images.
    """
    encoder_sha256 = export_encoder(folder, model.encoder, images)
    with torch.inference_mode():
        mean, _ = model.encoder(network_input(images), torch.Generator().manual_seed(SEED))
    return FlightForm(
        encoder_sha256=encoder_sha256,
        policies_sha256=export_policies(folder, model.policies, mean.numpy()),
    )


def export_encoder(folder: Path, encoder: Dronet, images: RgbStack) -> str:
    """Write an encoder's graph into its model's folder, and return its hash; as `export_model`."""
    generator, latent_dims = torch.Generator().manual_seed(SEED), encoder.head.latent_dims
    masks = dropout_mask(torch.empty(TRACED, FEATURES), encoder.dropout, generator)
    noise = torch.randn((TRACED, latent_dims), generator=generator)
    calls = [(torch.from_numpy(rgb[None]), masks, noise) for rgb in images]
    signature = encoder_signature(latent_dims)
    return _export(FlightEncoder(encoder), calls, folder / ENCODER_FILE, signature)


def export_policies(folder: Path, policies: PolicyStack, z: Latents) -> str:
    """Write policies' graph into their model's folder, and return its hash; as `export_model`."""
    members, latent_dims, _ = policies.dense1.weight.shape
    signature = policies_signature(members, latent_dims)
    calls = [(torch.from_numpy(z),)]
    return _export(FlightPolicies(policies), calls, folder / POLICIES_FILE, signature)


def export_detector(folder: Path, network: GateNetwork, images: RgbStack) -> DetectorFlightForm:
    """Write a detector's graph into its model's folder, and return its hash; as `export_model`."""
    calls = [(torch.from_numpy(rgb[None]),) for rgb in images]
    path = folder / DETECTOR_FILE
    sha256 = _export(FlightDetector(network), calls, path, DETECTOR_SIGNATURE)
    return DetectorFlightForm(detector_sha256=sha256)


def _export(
    network: nn.Module, calls: Sequence[tuple[Tensor, ...]], path: Path, signature: Signature
) -> str:
    """Trace a network's first call, write its graph, and compare both on all calls."""
    network = network.eval()
    onnx.save(_trace(network, calls[0], signature), path)
    sha256 = file_sha256(path)
    graph = Graph(path, sha256=sha256, signature=signature)
    names = list(signature.outputs)
    for call in calls:
        with torch.inference_mode():
            answer = network(*call)
        expected = answer if isinstance(answer, tuple) else (answer,)
        inputs = {name: value.numpy() for name, value in zip(signature.inputs, call, strict=True)}
        for name, said, meant in zip(names, graph.run(names, inputs), expected, strict=True):
            apart = float(np.abs(said - meant.numpy()).max())
            if not apart <= MAX_DIFFERENCE:
                raise ModelError(f"{path}: {name} is {apart:.1g} off the network that was trained")
    return sha256


def _trace(
    network: nn.Module, example: tuple[Tensor, ...], signature: Signature
) -> onnx.ModelProto:
    sizes = torch.export.Dim.DYNAMIC
    shapes = tuple(
        {axis: sizes for axis, size in enumerate(shape) if size is None}
        for shape in signature.inputs.values()
    )
    quiet, level = logging.getLogger("torch.onnx"), logging.getLogger("torch.onnx").level
    quiet.setLevel(logging.ERROR)  # it says which operators of other libraries it does without
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of torch to itself
            program = torch.onnx.export(
                network,
                example,
                input_names=list(signature.inputs),
                output_names=list(signature.outputs),
                dynamic_shapes=shapes,
                opset_version=OPSET,
                dynamo=True,
                verbose=False,
            )
    finally:
        quiet.setLevel(level)
    if program is None:
        raise ModelError("torch exported nothing")
    return _stripped(program.model_proto)


def _stripped(model: onnx.ModelProto) -> onnx.ModelProto:
    """Leave the graph alone: where on a disk it was traced, and by what, is nobody's business."""
    graph = model.graph
    for part in (model, graph, *graph.node, *graph.initializer, *graph.input, *graph.output):
        part.ClearField("metadata_props")
        part.ClearField("doc_string")
    graph.ClearField("value_info")
    model.ClearField("metadata_props")
    return model


def _scaled(rgb: UInt8[Tensor, "1 64 64 3"]) -> Float[Tensor, "1 3 64 64"]:
    """As `images.tensor_input`, nothing overwritten."""
    return rgb.permute(0, 3, 1, 2).to(torch.float32) / WHITE - 1.0
