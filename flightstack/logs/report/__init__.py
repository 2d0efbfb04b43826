"""The report: one HTML page with all of a flight, that opens offline in any browser."""
