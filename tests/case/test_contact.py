"""Models of the ground contact: how deep shoes settle by each, and what is refused."""

import math

import pytest

from exudyn_crawler import Case, FlexibleShoes, LoadCycle, PairContact, SphereContact
from exudyn_crawler.case import Phase
from exudyn_crawler.errors import ParameterError

SPHERES = SphereContact.oil_sand()
CASE = Case.translation().with_(contact=SPHERES)


def test_spheres_carry_the_mean_load_at_the_pair_laws_depth():
    depth = math.sqrt(432.3e3 / 1e8)  # papers: 6.57 cm
    assert CASE.settled_penetration == pytest.approx(depth, rel=1e-3)
    spheres = SPHERES.spheres_x * SPHERES.spheres_y
    assert spheres * CASE.sphere_stiffness * CASE.settled_penetration == pytest.approx(
        CASE.mean_load, rel=1e-12
    )


def test_the_reference_law_sets_how_deep_shoes_settle():
    assert CASE.settled_penetration == Case.translation().settled_penetration
    stiff = CASE.with_(contact=SPHERES.with_(reference_stiffness=4.0 * SPHERES.reference_stiffness))
    assert stiff.settled_penetration == pytest.approx(0.5 * CASE.settled_penetration, rel=1e-12)
    assert stiff.sphere_stiffness == pytest.approx(2.0 * CASE.sphere_stiffness, rel=1e-12)


def test_each_model_is_had_where_it_is_the_case_s():
    assert CASE.sphere_contact() == SPHERES
    assert Case.translation().pair_contact() == PairContact.adams()
    with pytest.raises(ValueError, match=r"contact\.model must be 'pair', got 'spheres'"):
        CASE.pair_contact()
    with pytest.raises(ValueError, match=r"contact\.model must be 'spheres', got 'pair'"):
        Case.translation().sphere_contact()


def test_unknown_model_is_refused():
    with pytest.raises(
        ParameterError, match=r"^contact\.model: must be 'pair' or 'spheres' or 'cells', got 'hertz'$"
    ):
        CASE.with_(contact=SPHERES.model_dump() | {"model": "hertz"})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"spheres_x": 1}, "spheres_x"),
        ({"spheres_y": 0}, "spheres_y"),
        ({"radius": -0.1}, "radius"),
        ({"damping": -1.0}, "damping"),
        ({"friction": -0.1}, "friction"),
        ({"friction_speed": 0.0}, "friction_speed"),
        ({"radius": math.inf}, "radius"),
    ],
)
def test_bad_spheres_are_refused(changes, message):
    with pytest.raises(ParameterError, match=message):
        SPHERES.with_(**changes)


def test_spheres_that_would_sink_through_are_refused():
    spheres = SPHERES.with_(radius=0.06)
    with pytest.raises(
        ParameterError, match=r"radius must exceed the settled penetration .* 0\.0657.* m, got 0\.06"
    ):
        CASE.with_(contact=spheres)


def test_growing_load_that_would_sink_a_sphere_through_is_refused():
    spheres = SPHERES.with_(radius=0.1)
    case = CASE.with_(contact=spheres)
    light, heavy = [386.4e3] * 13, [*[386.4e3] * 6, 732e3, *[386.4e3] * 6]
    loads = LoadCycle(
        phases=(Phase(name="propel", end=1, loads=light), Phase(name="swing", end=9, loads=heavy))
    )
    message = r"settled penetration of the most loaded shoe, 0\.1183 m, got 0\.1"
    with pytest.raises(ParameterError, match=message):
        case.with_(loads=loads)


def test_loads_that_lift_the_track_are_refused():
    with pytest.raises(ParameterError, match="loads must press the shoes down"):
        CASE.with_(loads=LoadCycle.constant([-1e6] * 13))


def test_spheres_too_large_for_the_units_are_refused():
    with pytest.raises(ParameterError, match=r"quarter of a unit's side, 1\.75 m, got 2"):
        CASE.with_(contact=SPHERES.with_(radius=2.0))


def test_flexible_shoes_are_refused():
    with pytest.raises(ParameterError, match=r"flexible must be None with contact\.model 'spheres'"):
        CASE.with_(flexible=FlexibleShoes.ph4100c("coarse"))
