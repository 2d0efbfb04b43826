"""Number what is fixed on the wire and in a tlog: who is who, and how a packet is laid out."""

AUTOPILOT_COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1
REFEREE_COMPONENT = 25  # MAV_COMP_ID_USER1: the simulator's judge of the course
CAMERA_COMPONENT = 100  # MAV_COMP_ID_CAMERA
COMPANION_COMPONENT = 191  # MAV_COMP_ID_ONBOARD_COMPUTER

MAGIC_V1, MAGIC_V2 = 0xFE, 0xFD  # a packet's first byte
HEADER_V1, HEADER_V2 = 6, 10  # bytes
CHECKSUM_BYTES = 2
SIGNATURE_BYTES = 13
SIGNED_FLAG = 0x01  # incompatibility flag
CRC_START = 0xFFFF  # CRC-16/MCRF4XX

LINK_BITS = 0x3  # the two lowest bits of a tlog's time: MAVProxy's number of the link
