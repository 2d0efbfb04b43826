"""File transfer, log download, and what the vehicle stores."""
