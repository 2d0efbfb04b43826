"""The mission protocol: plans up and down."""
