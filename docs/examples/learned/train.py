"""Train a small network in the gymnasium environment until it passes enough gates."""

import argparse

import numpy as np
import torch
from learned import WEIGHTS, LearnedPilot, shrink
from torch import nn

from flightstack.gym import GatesEnv, fly_in
from flightstack.gym.gates import RANGE

JUDGED = 1_000_000  # seed of the first lap that it is judged by, on tracks that it has not seen


def teach(gate: np.ndarray) -> np.ndarray:
    """Return the action towards a gate (forward, right, down, axis): 1.5 m/s, nose first."""
    ahead_m = max(float(np.hypot(*gate[:2])), 0.8)
    turn = 1.5 * (np.arctan2(gate[1], gate[0]) if ahead_m > 1.5 else gate[3])
    return (np.array([*(1.5 * gate[:3] / ahead_m), turn]) - RANGE.offset) / RANGE.scale


def train(gates: int, laps: int, flights: int, noise: tuple[float, float]) -> None:
    """Fly by the teacher, later by the network; learn what the teacher would have done (DAgger)."""
    env, pilot, images, actions = GatesEnv(noise=noise), LearnedPilot(None), [], []
    optimiser, rng = torch.optim.Adam(pilot.parameters()), np.random.default_rng(0)
    seed = passed = 0
    while passed < gates:
        ends, (observed, info) = [False], env.reset(seed=seed)
        while not any(ends):
            images.append(shrink(observed["image"]))
            actions.append(teach(info["gate"]))
            flown = pilot(images[-1])[0].detach().numpy() if seed >= flights else actions[-1]
            observed, _, *ends, info = env.step(flown + rng.normal(0.0, 0.05, 4))
        seed += 1
        if seed % flights == 0:
            seen, wanted = torch.cat(images), torch.tensor(np.array(actions), dtype=torch.float32)
            for batch in torch.cat([torch.randperm(len(seen)) for _ in range(8)]).split(64):
                optimiser.zero_grad()
                nn.functional.mse_loss(pilot(seen[batch]), wanted[batch]).backward()
                optimiser.step()
            passed = sum(fly_in(env, pilot, seed=JUDGED + k)["gates_passed"] for k in range(laps))
            print(f"{seed} flights, {len(seen)} images: {passed} of {8 * laps} gates", flush=True)
    torch.save(pilot.state_dict(), WEIGHTS)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gates", type=int, default=22, help="to be passed, of 8 a lap (22)")
    parser.add_argument("--laps", type=int, default=3, help="that it is judged by (3)")
    parser.add_argument("--flights", type=int, default=6, help="between two trainings (6)")
    parser.add_argument("--noise", type=float, nargs=2, default=(0.5, 1.0), help="of gates, m")
    torch.manual_seed(0)
    train(**vars(parser.parse_args()))
