"""Training of the gate detector: scenes with sets of gates, the network, its calibration."""
