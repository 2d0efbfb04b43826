"""The companion's end of the MAVLink wire: transport, link, commands, setpoints, telemetry, log."""
