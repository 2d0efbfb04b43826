"""The shapes in signatures are checked wherever a test calls a function, and nowhere else."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import torch
from jaxtyping import TypeCheckError

from flightstack.decision.density import find_modes
from flightstack.decision.strategies import make_strategy
from flightstack.networks.cmvae import kl_to_standard_normal
from flightstack.policy.scales import VelocityRange
from flightstack.records import ActionSamples
from tests.paths import ROOT

IN_FLIGHT = """
import sys
import numpy as np
from flightstack.companion import pipeline
from flightstack.decision.density import find_modes
assert find_modes(np.zeros((32, 3))).grid.shape == (3, 64)
assert "beartype" not in sys.modules
"""


def test_an_array_of_another_shape_is_refused_with_its_name() -> None:
    with pytest.raises(TypeCheckError, match="'values'"):
        find_modes(np.zeros((32, 3)))


def test_an_array_of_another_type_is_refused() -> None:
    with pytest.raises(TypeCheckError, match="'command'"):
        VelocityRange().clip(np.zeros(4, dtype=np.float32))


def test_tensors_that_differ_where_they_should_agree_are_refused() -> None:
    with pytest.raises(TypeCheckError, match="'logvar'"):
        kl_to_standard_normal(torch.zeros(8, 10), torch.zeros(8, 9))


def test_fields_of_a_record_that_disagree_are_refused() -> None:
    samples = ActionSamples(mean=np.zeros((5, 32, 4)), var=np.ones((5, 32, 4)))
    decision = make_strategy("de-mean").decide(samples)
    with pytest.raises(TypeCheckError, match="member_mean"):
        replace(decision, member_mean=np.zeros((3, 4)))


def test_nothing_is_checked_in_flight() -> None:
    done = subprocess.run([sys.executable, "-c", IN_FLIGHT], cwd=ROOT, check=False)
    assert done.returncode == 0
