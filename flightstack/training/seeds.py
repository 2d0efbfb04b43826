"""Which seeds are for what, so that training, validation and test never meet.

Tracks: a person's `--track-seed` and every evaluation draw from TEST_TRACKS; the training of
policies flies TRAINING_TRACKS and measures itself on VALIDATION_TRACKS.
"""

TEST_TRACKS = range(1_000_000)
TRAINING_TRACKS = range(10_000_000, 20_000_000)
VALIDATION_TRACKS = range(20_000_000, 30_000_000)
TRAINING_SCENES = range(11, 91)  # of the gate detector: a seed a file of scenes
VALIDATION_SCENES = range(99, 100)
EXPORT_VIEWS = 7_000_000  # of the views on which a flight form is held against its networks
