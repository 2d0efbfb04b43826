"""Fly one trial: the vehicle and the companion as two real processes over real sockets."""
