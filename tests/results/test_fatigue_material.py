"""Fatigue strength by FKM: hand numbers, tendencies, refusals."""

import numpy as np
import pytest

from exudyn_crawler import FatigueMaterial
from exudyn_crawler.errors import ParameterError
from fem.defects import CycleStage, Defect, growth


def test_strength_by_hand():
    """FKM, cast steel of 860 MPa with a casting skin: f_W 0.34, a_R 0.20, R_m,N,min 400 MPa, K_f 2."""
    material = FatigueMaterial.cast_nicrmo()
    roughness = 1.0 - 0.20 * np.log10(200.0) * np.log10(2.0 * 860.0 / 400.0)
    design = 1.0 + 0.5 * (1.0 / roughness - 1.0)
    factors = material.factors()
    assert factors["roughness"] == pytest.approx(roughness)
    assert factors["mean_sensitivity"] == pytest.approx(0.35e-3 * 860.0 + 0.05)
    assert material.curve().strength == pytest.approx(0.34 * 860e6 / design / 1.25)
    assert FatigueMaterial.a36().factors()["fatigue_strength"] == pytest.approx(0.45 * 400e6)


def test_support_of_a_gradient_is_stielers():
    """It is 1 + G 10^-(a_G - 0.5 + R_m / b_G) for G up to 0.1 1/mm, a_G 0.5 and b_G 2700 MPa of steel."""
    material = FatigueMaterial.a36().with_(stress_gradient=80.0)
    assert material.factors()["support"] == pytest.approx(1.0 + 0.08 * 10.0 ** -(400.0 / 2700.0))


@pytest.mark.parametrize(
    ("change", "sense"),
    [
        ({"roughness": 4e-4}, -1),
        ({"roughness": 1e-5}, 1),
        ({"stress_gradient": 200.0}, 1),
        ({"casting_factor": 1.4}, -1),
        ({"size_factor": 0.85}, -1),
        ({"tensile_strength": 950e6}, 1),
        ({"fatigue_strength": 250e6}, -1),
    ],
)
def test_what_makes_a_part_stronger_or_weaker(change, sense):
    one = FatigueMaterial.cast_nicrmo()
    assert sense * (one.with_(**change).curve().strength - one.curve().strength) > 0.0


@pytest.mark.parametrize("name", ["a36", "cast_nicrmo", "cast_manganese"])
def test_ready_materials_say_what_they_assume(name):
    material = getattr(FatigueMaterial, name)()
    assert "assumed" in material.source
    assert 100e6 < material.curve("haibach").strength < 250e6


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"yield_strength": 250}, "yield_strength"),
        ({"yield_strength": 900e6}, "yield_strength must not exceed tensile_strength = 8.6e"),
        ({"fkm_class": "wood"}, "fkm_class"),
        ({"survival": 1.0}, "survival"),
    ],
)
def test_what_is_no_material_is_refused(change, words):
    with pytest.raises(ParameterError, match=words):
        FatigueMaterial.cast_nicrmo().with_(**change)


def test_castings_differ_by_region():
    path = {"region": "roller path", "residual_stress": -200e6}
    material = FatigueMaterial.cast_nicrmo().with_(castings=({"defect_size": 1e-3}, path))
    assert material.curve("elementary", "roller path").residual_stress == -200e6
    assert material.curve("elementary", "lugs") == FatigueMaterial.cast_nicrmo().curve()
    once = [CycleStage(np.zeros(1), np.array([300e6]), np.ones(1))]
    assert np.isnan(material.defect_life("roller path", "elementary", once, 0.975))
    own = Defect(1e-3, 860.0 / 3.2, 0.06), np.zeros(1), np.array([300e6]), np.ones(1)
    assert material.defect_life("lugs", "elementary", once, 0.9) == growth(*own, 0.9)[0] < 1e6
    # Murakami's limit of 50 micrometres is a range of 486 MPa from 0 (HV 860 / 3.2), of 552 MPa with HV 320
    small = material.with_(castings=({"defect_size": 5e-5},), fatigue_strength=860e6)
    more = [CycleStage(np.zeros(1), np.array([500e6]), np.ones(1))]
    materials = (small, small.with_(hardness=320))
    grows, sleeps = (one.defect_life("lugs", "elementary", more, 0.9) for one in materials)
    assert grows == growth(Defect(5e-5, 860.0 / 3.2, 0.06), *own[1:2], more[0].end, np.ones(1), 0.9)[0]
    assert sleeps > 10.0 * grows
    with pytest.raises(ParameterError, match="regions must differ"):
        material.with_(castings=(path, path))
    with pytest.raises(ParameterError, match="region"):
        material.with_(castings=({"region": "pin"},))
