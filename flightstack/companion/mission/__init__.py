"""What the companion does next: a state machine without socket, thread or clock."""
