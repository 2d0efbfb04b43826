"""Links over UDP and TCP, and what passes between them."""
