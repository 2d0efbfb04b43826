"""A flight form is its networks, and names no place; where it says anything else, it is refused."""

from pathlib import Path

import pytest
import torch

from flightstack.errors import ModelError
from flightstack.networks import export
from flightstack.networks.dronet import Dronet
from flightstack.networks.policy_stack import PolicyStack
from flightstack.perception.encoder import ENCODER_FILE
from flightstack.policy.config import PolicyConfig
from tests.paths import ROOT
from tests.unit.flightstack.exported import pixels


def make_encoder() -> Dronet:
    torch.manual_seed(0)
    return Dronet(latent_dims=10, dropout=0.2).eval()


def test_an_export_is_the_same_each_time_and_names_no_place(tmp_path: Path) -> None:
    first, again = (export.export_encoder(tmp_path, make_encoder(), pixels()) for _ in range(2))
    assert first == again
    content = (tmp_path / ENCODER_FILE).read_bytes()
    assert str(ROOT).encode() not in content
    assert b"site-packages" not in content


def test_a_graph_that_says_anything_else_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = PolicyConfig(members=2, probabilistic=True)
    stack = PolicyStack(config, latent_dims=10, generator=torch.Generator().manual_seed(0))
    other = PolicyStack(config, latent_dims=10, generator=torch.Generator().manual_seed(1))
    trace = export._trace
    monkeypatch.setattr(
        export,
        "_trace",
        lambda _, example, signature: trace(export.FlightPolicies(other), example, signature),
    )
    z = torch.randn((8, 10), generator=torch.Generator().manual_seed(2)).numpy()
    with pytest.raises(ModelError, match=r"policies\.onnx: mean is .* off the network"):
        export.export_policies(tmp_path, stack, z)
