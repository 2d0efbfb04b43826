"""Message definitions: the dialect that pymavlink carries."""
