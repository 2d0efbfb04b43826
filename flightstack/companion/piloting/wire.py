"""Write a decision as bytes, and read it: what a worker process tells of each image.

All numbers are float64: command, the three standard deviations, member, number of modes (four
each), then score and member mean (N x 4 each). The first byte of a message says what it is.
"""

import numpy as np

from flightstack.records import VELOCITIES, Decision

LOADED, READY, DECIDED, FAILED, REFUSED = b"L", b"R", b"D", b"F", b"X"
WIDTH = len(VELOCITIES)
FIXED = 6  # rows that do not depend on N


def write_decision(decision: Decision) -> bytes:
    """Return the bytes of a decision."""
    rows = (
        decision.command,
        decision.aleatoric_std,
        decision.epistemic_std,
        decision.perceptual_std,
        decision.member,
        decision.modes,
        decision.score,
        decision.member_mean,
    )
    return np.concatenate(rows, axis=None, dtype=np.float64).tobytes()


def read_decision(data: bytes) -> Decision:
    """Return the decision that the bytes tell of; raises ValueError where they tell of none."""
    rows = np.frombuffer(data, np.float64).reshape(-1, WIDTH)
    members = (len(rows) - FIXED) // 2
    return Decision(
        command=rows[0],
        aleatoric_std=rows[1],
        epistemic_std=rows[2],
        perceptual_std=rows[3],
        member=rows[4].astype(np.int64),
        modes=rows[5].astype(np.int64),
        score=rows[FIXED : FIXED + members],
        member_mean=rows[FIXED + members :],
    )
