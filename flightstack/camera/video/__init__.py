"""Coded video over a network: RTSP, RTP and MPEG transport streams, by PyAV."""
