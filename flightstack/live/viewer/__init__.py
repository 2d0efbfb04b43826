"""The viewer in a browser: its files, its page, and the server of both."""
