"""The physical world: vehicle body, gates and scenery, course and referee."""
