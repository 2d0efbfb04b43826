"""Fly in simulation: vehicle and companion as two processes, and what came of it as a record.

from flightstack.launch import fly

result = fly(track_seed=7, noise=(1.0, 2.0))
print(result.outcome, result.gates_passed, result.log)
"""

from flightstack.launch.flight import fly
from flightstack.launch.result import FlightResult

__all__ = ["FlightResult", "fly"]
