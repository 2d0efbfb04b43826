"""The numbers of the belief; docs/belief.md says which were chosen on validation tracks."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSettings:
    """How gates are tracked."""

    drift_std_m_s: float = 0.08  # of the estimate against the gates, along each axis
    drift_time_constant_s: float = 3.0
    walk_m_sqrt_s: float = 0.05  # of a gate in the estimate's frame
    heading_walk_rad_sqrt_s: float = 0.02
    max_position_std_m: float = 1.5
    covariance_factor: float = 2.0  # on a detection's: errors of one image are those of the next
    lateral_floor_m: tuple[float, float] = (0.04, 0.02)  # and per metre of distance
    range_floor_m: tuple[float, float] = (0.10, 0.06)
    heading_variance_factor: float = 15.0
    min_heading_std_rad: float = 0.3  # what is seen of a heading errs alike from image to image
    blind_m: float = 0.9  # nearer, a detection moves nothing
    gate_chi2: float = 16.0  # squared Mahalanobis distance at which a detection is another gate's
    birth_score: float = 0.35
    birth_log_odds: float = -0.5
    hit_log_odds: float = 0.8  # times the score
    miss_log_odds: float = 0.35
    min_log_odds: float = -2.0
    max_log_odds: float = 5.0
    merge_m: float = 0.8
    max_tracks: int = 24
    expected_m: tuple[float, float] = (1.2, 8.0)  # where a gate in view should be seen
    expected_tangent: float = 0.85


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseSettings:
    """What is known of courses before any gate is passed, and how passing is judged."""

    chord_m: float = 6.0
    chord_std_m: tuple[float, float] = (2.5, 1.4)  # before and after the course has told
    turn_std_rad: tuple[float, float] = (0.8, 0.4)
    axis_std_rad: tuple[float, float] = (0.35, 0.22)
    max_axis_rad: float = 0.8  # from what the course says: what is seen beyond is not believed
    first_bearing_std_rad: float = 0.6
    first_range_m: float = 4.0  # the first gate is the nearest: standard deviation about here
    passed_behind_m: float = 0.25
    passed_beside_m: float = 1.3
    recent: int = 4  # gates passed last, which cannot be next
    lock_m: float = 2.5  # nearer, a gate that is flown to stays the next one
    stay_bonus: float = 1.0  # farther, another has to be so much likelier, log-weight
    min_existence: float = 0.3  # log-odds of a gate that is flown to
    pair_gap_m: tuple[float, float] = (1.4, 3.3)
    pair_ahead_m: float = 1.3
    pair_height_m: float = 0.7
    wrong_side_penalty: float = 6.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LawSettings:
    """How a believed gate is flown: the law of the expert that trains policies."""

    speed_m_s: float = 2.0
    centring_speed_m_s: float = 1.6
    look_ahead_m: float = 1.8
    look_ahead_share: float = 0.7
    max_lateral_m_s: float = 1.6
    max_vertical_m_s: float = 1.2
    back_off_share: float = 0.25
    turn_distance_m: float = 2.0
    yaw_gain_1_s: float = 1.5
    max_yaw_rate_rad_s: float = 1.0
    lead_s: float = 0.3  # the vehicle answers a velocity so late
    search_speed_m_s: float = 0.7
    search_yaw_rate_rad_s: float = 0.6
    command_std: tuple[float, float, float, float] = (0.05, 0.05, 0.05, 0.05)
