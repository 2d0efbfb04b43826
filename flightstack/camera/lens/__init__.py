"""What a lens does to the view, and how it is undone."""
