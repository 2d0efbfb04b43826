"""Judge models on images that they have not seen, without a flight."""
