"""Models of the ground contact: how deep shoes settle by each, and what is refused."""

import math

import pytest

from exudyn_crawler import Case, FlexibleShoes, LoadCycle, PairContact, SphereContact
from exudyn_crawler.case import Phase, statics
from exudyn_crawler.errors import ParameterError

SPHERES = SphereContact.oil_sand()
CASE = Case.translation().with_(contact=SPHERES)


def test_spheres_carry_the_mean_load_at_the_pair_laws_depth():
    depth = math.sqrt(432.3e3 / 1e8)  # papers: 6.57 cm
    settled = statics.settled_penetration(CASE)
    assert settled == pytest.approx(depth, rel=1e-3)
    each = statics.sphere_stiffness(CASE, SPHERES)
    carried = SPHERES.spheres_x * SPHERES.spheres_y * each * settled
    assert carried == pytest.approx(statics.mean_load(CASE), rel=1e-12)
    # which is the reference law's
    assert settled == statics.settled_penetration(Case.translation())
    stiff = CASE.with_(contact=SPHERES.with_(reference_stiffness=4.0 * SPHERES.reference_stiffness))
    assert statics.settled_penetration(stiff) == pytest.approx(0.5 * settled, rel=1e-12)
    assert statics.sphere_stiffness(stiff, stiff.contact) == pytest.approx(2.0 * each, rel=1e-12)


def test_each_model_is_had_where_it_is_the_case_s():
    assert CASE.part(SphereContact) == SPHERES
    assert Case.translation().part(PairContact) == PairContact.adams()
    with pytest.raises(ValueError, match=r"contact\.model must be 'pair', got 'spheres'"):
        CASE.part(PairContact)
    with pytest.raises(ValueError, match=r"contact\.model must be 'spheres', got 'pair'"):
        Case.translation().part(SphereContact)


LIGHT = Phase(name="propel", end=1, loads=[386.4e3] * 13)
HEAVY = Phase(name="swing", end=9, loads=[*[386.4e3] * 6, 732e3, *[386.4e3] * 6])
UNEVEN = LoadCycle(phases=(LIGHT, HEAVY))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"contact.spheres_x": 1}, "spheres_x"),
        ({"contact.spheres_y": 0}, "spheres_y"),
        ({"contact.radius": -0.1}, "radius"),
        ({"contact.radius": math.inf}, "radius"),
        ({"contact.damping": -1.0}, "damping"),
        ({"contact.friction": -0.1}, "friction"),
        ({"contact.friction_speed": 0.0}, "friction_speed"),
        ({"contact.radius": 0.06}, r"radius must exceed the settled penetration .* 0\.0657.* m, got 0\.06"),
        ({"contact.radius": 0.1, "loads": UNEVEN}, r"of the most loaded shoe, 0\.1183 m, got 0\.1"),
        ({"contact.radius": 2.0}, r"quarter of a unit's side, 1\.75 m, got 2"),
        ({"loads": LoadCycle.constant(-1e6)}, "loads must press the shoes down"),
        (
            {"flexible": FlexibleShoes.ph4100c("coarse")},
            r"flexible must be none with contact\.model 'spheres'",
        ),
    ],
)
def test_spheres_that_would_sink_through_or_do_not_go_with_the_case_are_refused(changes, message):
    with pytest.raises(ParameterError, match=message):
        CASE.with_(changes)
