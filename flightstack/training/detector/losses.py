"""What the detector is trained on: scores by focal loss, the rest by the beta-NLL of its variances.

References:
    Lin et al. 2017, "Focal loss for dense object detection".
    Seitzer et al. 2022, "On the pitfalls of heteroscedastic uncertainty estimation with
    probabilistic neural networks": beta-NLL, beta = 0.5.
"""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from flightstack.networks.gate_network import (
    ANGLE,
    CENTRE,
    LOGVARS,
    RANGE,
    SCORE,
    CellTensor,
)
from flightstack.perception.gate_decoding import CELLS

CELL_PX = 4
BETA = 0.5
FOCUS, POSITIVE_SHARE = 2.0, 0.75
SCORE_WEIGHT = 8.0
WEIGHTS = (1.0, 1.0, 1.0, 0.7)  # of u, v, the distance, the angle


class Targets(NamedTuple):
    """What the cells should say; only where `is_gate` does more than the score count."""

    is_gate: Bool[Tensor, "B 16 16"]
    is_near: Bool[Tensor, "B 16 16"]  # to a gate's cell: neither right nor wrong
    values: Float[
        Tensor, "B 5 16 16"
    ]  # u, v in cells, log distance, cos and sin of twice the angle


def targets_of(labels: Float[Tensor, "B G 4"]) -> Targets:
    """Lay labels (u, v in px, distance, angle; NaN where there is none) into cells."""
    count, most, _ = labels.shape
    is_gate = torch.zeros(count, CELLS, CELLS, dtype=torch.bool)
    values = torch.zeros(count, 5, CELLS, CELLS)
    rows = torch.arange(count)
    for index in reversed(range(most)):  # the nearest comes last, and stays
        u, v, distance_m, angle = labels[:, index].unbind(1)
        there = torch.isfinite(u)
        at = rows[there]
        column = (u[there] / CELL_PX).long().clamp(0, CELLS - 1)
        row = (v[there] / CELL_PX).long().clamp(0, CELLS - 1)
        is_gate[at, row, column] = True
        values[at, :, row, column] = torch.stack(
            (
                u[there] / CELL_PX - column - 0.5,
                v[there] / CELL_PX - row - 0.5,
                torch.log(distance_m[there]),
                torch.cos(2.0 * angle[there]),
                torch.sin(2.0 * angle[there]),
            ),
            dim=1,
        )
    spread = torch.nn.functional.max_pool2d(is_gate[:, None].float(), 3, stride=1, padding=1)
    return Targets(is_gate, (spread[:, 0] > 0.0) & ~is_gate, values)


def loss_of(cells: CellTensor, targets: Targets) -> tuple[Tensor, Tensor]:
    """Return the loss of the scores and that of the rest, each per gate."""
    gates = max(int(targets.is_gate.sum()), 1)
    score = _focal(cells[:, SCORE], targets).sum() / gates
    chosen = cells.permute(0, 2, 3, 1)[targets.is_gate]
    wanted = targets.values.permute(0, 2, 3, 1)[targets.is_gate]
    said = torch.cat((chosen[:, CENTRE], chosen[:, RANGE : RANGE + 1]), dim=1)
    squares = (said - wanted[:, :3]).square()
    vector = chosen[:, ANGLE]
    angle = (vector - wanted[:, 3:]).square().sum(dim=1, keepdim=True) / 2.0
    logvars = chosen[:, LOGVARS]
    errors = torch.cat((squares, angle), dim=1)
    likelihood = 0.5 * (errors * torch.exp(-logvars) + logvars)
    weighed = likelihood * torch.exp(BETA * logvars).detach()
    return score, (weighed * torch.tensor(WEIGHTS)).sum() / gates


def _focal(logits: Tensor, targets: Targets) -> Tensor:
    share = torch.sigmoid(logits)
    positive = -POSITIVE_SHARE * (1 - share) ** FOCUS * torch.nn.functional.logsigmoid(logits)
    negative = -(1 - POSITIVE_SHARE) * share**FOCUS * torch.nn.functional.logsigmoid(-logits)
    return torch.where(targets.is_gate, positive, negative * ~targets.is_near)
