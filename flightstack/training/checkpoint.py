"""Keep a training's state on disk so that an interrupted one goes on to the same result."""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import torch
from torch import nn
from torch.optim import Optimizer

from flightstack.errors import UsageError
from flightstack.files import replacing
from flightstack.training.errors import TrainingError

FILE_NAME = "checkpoint.pt"


class Checkpoint:
    """One file in a run's folder: the networks, the optimiser and how many epochs are done.

    `identity` names everything that the result depends on. A checkpoint written under another
    identity is refused, since going on from it would give neither result.
    """

    def __init__(
        self, folder: Path, *, identity: dict[str, Any], model: nn.Module, optimizer: Optimizer
    ) -> None:
        self._path = folder / FILE_NAME
        self._identity = json.dumps(identity, sort_keys=True)
        self._model, self._optimizer = model, optimizer

    def train(self, epoch: Callable[[int], float], numbers: range) -> Iterator[tuple[int, float]]:
        """Pass over the data, by `epoch`, and save; yields the epochs done and the mean loss.

        Raises TrainingError where the loss is not finite.
        """
        for number in numbers:
            loss = epoch(number)
            if not math.isfinite(loss):
                raise TrainingError(
                    f"{self._path.parent.name}: the loss is {loss} in epoch {number + 1}: "
                    "lower the learning rate"
                )
            self.save(epochs_done=number + 1)
            yield number + 1, loss

    def save(self, *, epochs_done: int) -> None:
        """Replace the file in one step."""
        state = {
            "identity": self._identity,
            "epochs_done": epochs_done,
            "model": self._model.state_dict(),
            "optimizer": self._optimizer.state_dict(),
        }
        with replacing(self._path) as draft:
            torch.save(state, draft)

    def restore(self) -> int:
        """Load the file if there is one; returns how many epochs are done.

        Raises UsageError when the file is damaged or belongs to other settings or other data.
        """
        if not self._path.exists():
            return 0
        advice = f"remove {self._path.parent} to start afresh, or choose another folder"
        try:
            state = torch.load(self._path, weights_only=True, map_location="cpu")
        except (RuntimeError, OSError, EOFError, ValueError, UnpicklingError) as error:
            raise UsageError(f"{self._path} is damaged ({_first_line(error)}): {advice}") from error
        if state["identity"] != self._identity:
            changed = _changed(json.loads(state["identity"]), json.loads(self._identity))
            raise UsageError(f"{self._path} was written with another {changed}: {advice}")
        self._model.load_state_dict(state["model"])
        self._optimizer.load_state_dict(state["optimizer"])
        return int(state["epochs_done"])


def identity_of(settings: Any, *, data_sha256: str) -> dict[str, Any]:
    """Name everything that a training's result depends on, which its being judged is not."""
    named = {name: value for name, value in asdict(settings).items() if name != "must_learn"}
    return {**named, "data": data_sha256}


def _changed(before: dict[str, Any], after: dict[str, Any]) -> str:
    keys = [key for key in sorted(before | after) if before.get(key) != after.get(key)]
    return ", ".join(keys)


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
