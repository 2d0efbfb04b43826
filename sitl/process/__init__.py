"""The process around the simulation: command line, server, pacing, lockstep."""
