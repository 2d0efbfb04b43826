from pathlib import Path
from typing import Any

import pytest
import torch
from torch import nn

from flightstack.errors import UsageError
from flightstack.training.checkpoint import Checkpoint


def make_network(seed: int) -> tuple[nn.Linear, torch.optim.AdamW]:
    torch.manual_seed(seed)
    network = nn.Linear(3, 2)
    optimizer = torch.optim.AdamW(network.parameters(), lr=0.1)
    step(network, optimizer)
    return network, optimizer


def step(network: nn.Linear, optimizer: torch.optim.Optimizer) -> None:
    optimizer.zero_grad()
    network(torch.ones(4, 3)).square().mean().backward()
    optimizer.step()


def test_restored_training_goes_on_as_if_nothing_had_happened(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    Checkpoint(tmp_path, identity={"seed": 0}, model=network, optimizer=optimizer).save(
        epochs_done=3
    )
    step(network, optimizer)

    other, other_optimizer = make_network(1)
    checkpoint = Checkpoint(tmp_path, identity={"seed": 0}, model=other, optimizer=other_optimizer)
    assert checkpoint.restore() == 3
    step(other, other_optimizer)
    assert torch.equal(other.weight, network.weight)


def test_no_file_means_no_epochs(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    checkpoint = Checkpoint(tmp_path, identity={}, model=network, optimizer=optimizer)
    assert checkpoint.restore() == 0


def test_other_settings_are_refused_by_name(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    networks: dict[str, Any] = {"model": network, "optimizer": optimizer}
    Checkpoint(tmp_path, identity={"seed": 0, "batch": 64}, **networks).save(epochs_done=1)
    other = Checkpoint(tmp_path, identity={"seed": 0, "batch": 32}, **networks)
    with pytest.raises(UsageError, match="written with another batch: remove"):
        other.restore()


def test_damaged_file_is_one_clear_error(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    checkpoint = Checkpoint(tmp_path, identity={}, model=network, optimizer=optimizer)
    checkpoint.save(epochs_done=1)
    path = tmp_path / "checkpoint.pt"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(UsageError, match=r"checkpoint\.pt is damaged .*: remove"):
        checkpoint.restore()
