"""Two-body problem of the K-paper: by hand, by the engine and as printed."""

import pytest

from exudyn_crawler import PairContact
from studies import two_bodies

pytestmark = pytest.mark.simulation

LAW = PairContact.oil_sand()


@pytest.fixture(scope="module")
def engine():
    return two_bodies.engine_solution(LAW)


def test_engine_and_hand_agree_to_rounding_and_every_kind_has_a_value_that_is_not_zero(engine):
    side_by_side = two_bodies.compare_verification(two_bodies.hand_solution(LAW), engine)
    assert len(side_by_side) == 3 + 1 + 1 + 3 * 3
    for row in side_by_side.itertuples():
        # what is zero by hand is rounding of forces of 1e7 N or moments of 1e8 N m
        assert row.engine == pytest.approx(row.hand, rel=1e-9, abs=1e-9 if "m/s2" in row.unit else 1e-2)
    for word in ("acceleration", "plate force", "drive", "hold moment", "fixing force", "fixing moment"):
        assert side_by_side[side_by_side["quantity"].str.contains(word)]["hand"].abs().max() > 1.0, word


def test_engine_gives_the_printed_values(engine):
    table = two_bodies.compare_with_paper(engine)
    assert len(table) == 2
    assert table["ratio"].tolist() == pytest.approx([1.0, 1.0], abs=1e-4)
    assert table["within"].tolist() == ["yes", "yes"]


def test_the_penetration_gives_the_printed_force():
    depth = two_bodies.block_penetration(LAW)
    assert LAW.stiffness * depth**2 + LAW.damping * 0.02 == pytest.approx(two_bodies.NORMAL_FORCE, rel=1e-12)
    assert depth > LAW.damping_depth


def test_friction_is_dynamic_and_its_moment_has_the_papers_arm():
    hand = two_bodies.hand_solution(LAW)
    assert hand.drive_force == pytest.approx(0.3 * 44275.0, rel=1e-12)
    # 11.5 m behind the plate's centre; the friction's arm is half the plate's height less some cm
    assert -hand.fixing_moment[1] + 11.5 * 44275.0 == pytest.approx(0.5 * 0.3 * 44275.0, rel=0.03)
