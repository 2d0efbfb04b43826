"""The camera's images over HTTP and as video over RTP."""
