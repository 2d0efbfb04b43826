"""What is to be flown: trials, competitors, and rows of results."""
