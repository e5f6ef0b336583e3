"""Flutter of an uneven track: no growth while it is even, growth beyond the threshold."""

import pytest

from studies.flutter import flutter


def test_a_track_flutters_beyond_a_threshold_of_unevenness():
    table = flutter([0.0, 0.17, 0.25]).set_index("unevenness")
    assert table.growth[0.0] < 0.0
    assert 0.1 < table.growth[0.17] < 1.0
    assert table.growth[0.25] > 2.0
    # two swings of a shoe on the ground meet: heave at 53 rad/s and roll at 41 rad/s, alone
    assert 41.0 < 2.0 * 3.14159 * table.frequency[0.25] < 53.0
    # 12 d e / W**2 by closed form for small rolls, beside what the unit rolls the other way
    expected = 12.0 * 0.0657 * 0.25 / 3.505**2
    assert table.roll[0.25] + table.roll[0.0] == pytest.approx(expected, rel=0.1)
