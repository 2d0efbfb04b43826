"""Packets to columns: one table a message type, numbers computed on them."""
