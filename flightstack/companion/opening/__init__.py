"""Open what a flight needs: the vehicle is found, its camera named and opened."""
