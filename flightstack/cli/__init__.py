"""The one command, `flightstack`: its sub-commands, their options from files, its completion."""
