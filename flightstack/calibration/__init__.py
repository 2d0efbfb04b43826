"""What a camera must be known for: its lens, and how late its images are."""
