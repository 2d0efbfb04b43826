"""Who commands: modes, arming, failsafes, commands of others."""
