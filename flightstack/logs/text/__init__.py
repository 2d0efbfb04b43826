"""Logs as text: summary, lines of a dump, expressions."""
