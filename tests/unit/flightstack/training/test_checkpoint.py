from pathlib import Path

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
    Checkpoint(tmp_path, identity={"seed": 0}).save(
        epochs_done=3, model=network, optimizer=optimizer
    )
    step(network, optimizer)

    other, other_optimizer = make_network(1)
    checkpoint = Checkpoint(tmp_path, identity={"seed": 0})
    assert checkpoint.restore(model=other, optimizer=other_optimizer) == 3
    step(other, other_optimizer)
    assert torch.equal(other.weight, network.weight)


def test_no_file_means_no_epochs(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    checkpoint = Checkpoint(tmp_path, identity={})
    assert checkpoint.restore(model=network, optimizer=optimizer) == 0


def test_other_settings_are_refused_by_name(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    Checkpoint(tmp_path, identity={"seed": 0, "batch": 64}).save(
        epochs_done=1, model=network, optimizer=optimizer
    )
    with pytest.raises(UsageError, match="written with another batch: remove"):
        Checkpoint(tmp_path, identity={"seed": 0, "batch": 32}).restore(
            model=network, optimizer=optimizer
        )


def test_damaged_file_is_one_clear_error(tmp_path: Path) -> None:
    network, optimizer = make_network(0)
    checkpoint = Checkpoint(tmp_path, identity={})
    checkpoint.save(epochs_done=1, model=network, optimizer=optimizer)
    path = tmp_path / "checkpoint.pt"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(UsageError, match=r"checkpoint\.pt is damaged .*: remove"):
        checkpoint.restore(model=network, optimizer=optimizer)
