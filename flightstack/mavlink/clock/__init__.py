"""The vehicle's clock, by TIMESYNC: asked for, and fitted between the bounds that answers leave."""
