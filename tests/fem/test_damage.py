"""Damage over histories of stress: closed forms, criteria against each other, what must not change it."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import fem
from fem import damage_on_planes
from fem.body.element_stress import evaluate, principal
from fem.fatigue import critical_plane, damage
from fem.fatigue.critical_plane import critical_planes, normal_stress_rows, plane_normals, surface_normals
from fem.fatigue.damage import SIGNED_CRITERIA, Counting, recover_damage, signed_signals
from fem.fatigue.sn_curve import SNCurve
from fem.stress import extremes, low_rank
from tests.fem.refusals import refused

CURVE = SNCurve(strength=150e6, slope=5.0, knee=1e6, mean_sensitivity=0.2, scatter=1.3, survival=0.9)
TURNS = 8
"""Cycles of the histories below."""
PHASE = np.linspace(0.0, 2.0 * np.pi * TURNS, 64 * TURNS + 1)
ONE_PHASE = np.zeros(len(PHASE), dtype=np.int64)
EXACT = Counting(CURVE, (0.5, 0.9), ONE_PHASE)


def uniaxial(directions: np.ndarray) -> np.ndarray:
    """Stress modes (n, 6, 1) of tension along unit vectors (n, 3), 1 Pa per unit."""
    x, y, z = directions.T
    return np.stack((x * x, y * y, z * z, x * y, y * z, x * z), axis=1)[:, :, None]


def tangents(count: int) -> np.ndarray:
    angles = np.linspace(0.0, np.pi, count, endpoint=False) + 0.04
    return np.stack((np.cos(angles), np.sin(angles), np.zeros(count)), axis=1)


@pytest.mark.parametrize("criterion", SIGNED_CRITERIA)
def test_constant_amplitude_is_the_closed_form(criterion):
    """N = N_D (s (1 + M) / S)^-k of a swelling stress, at every node in proportion to its own."""
    sizes = np.array([1.0, 0.5, 0.25, 0.0])
    modes = uniaxial(tangents(4)) * sizes[:, None, None]
    q = 80e6 * (1.0 - np.cos(PHASE))[:, None]
    found = recover_damage(modes, q, criterion, EXACT, tolerance=None)
    one = TURNS / 1e6 * (80e6 * 1.2 / 150e6) ** 5
    assert found.damage[:, 1].sum(axis=1) == pytest.approx(one * sizes**5, rel=1e-9)
    assert found.ends.highest[:3] == pytest.approx(160e6 * sizes[:3])
    better = CURVE.strength_at(0.5) / 150e6
    assert found.damage[0, 0].sum() == pytest.approx(one / better**5, rel=1e-9)


def test_doubled_stresses_divide_the_life_by_two_to_the_slope():
    rng = np.random.default_rng(1)
    modes, q = rng.standard_normal((30, 6, 3)) * 1e6, 30.0 * rng.standard_normal((400, 3))
    counting = Counting(CURVE, (0.9,), np.zeros(400, dtype=np.int64))
    for criterion in SIGNED_CRITERIA:
        one, two = (recover_damage(modes, k * q, criterion, counting, tolerance=None).damage for k in (1, 2))
        assert two == pytest.approx(2**5 * one, rel=1e-9)


def test_in_a_uniaxial_case_all_criteria_agree():
    modes = uniaxial(tangents(12))
    q = (60e6 * np.sin(PHASE) + 30e6 * np.cos(3.0 * PHASE) + 10e6)[:, None]
    found = [recover_damage(modes, q, one, EXACT, tolerance=None) for one in SIGNED_CRITERIA]
    signed = [one.damage.sum(axis=2) for one in found]
    assert signed[0] == pytest.approx(signed[1], rel=1e-9)
    normals = np.tile([0.0, 0.0, 1.0], (12, 1))

    def damage_on(nodes, angles):
        return damage_on_planes(modes, q, normals, angles, EXACT, nodes, None)

    planes = critical_planes(damage_on, np.arange(12))
    # half a degree beside the greatest stress it is cos^2 of that, to the fifth power in the damage
    assert (planes.damage <= signed[0] * (1.0 + 1e-9)).all()
    assert planes.damage == pytest.approx(signed[0], rel=5 * np.radians(0.51) ** 2)
    across = plane_normals(normals, planes.angles[:, None])[:, 0]
    assert np.abs((across * tangents(12)).sum(axis=1)).min() > np.cos(np.radians(0.51))


def test_a_rotating_principal_stress_wears_no_single_plane_as_a_signed_scalar_says():
    """Tension whose direction turns: the scalars are constant and count nothing, each plane swells."""
    stress = np.zeros((1, 6, 3))
    stress[0, 0], stress[0, 1] = [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]
    stress[0, 3, 2] = 1.0
    q = 50e6 * np.stack((np.ones(len(PHASE)), np.cos(PHASE), np.sin(PHASE)), axis=1)
    for criterion in SIGNED_CRITERIA:
        assert recover_damage(stress, q, criterion, EXACT, tolerance=None).damage.max() < 1e-30
    angles = np.radians([[0.0, 20.0, 70.0]])
    found = damage_on_planes(stress, q, np.array([[0.0, 0.0, 1.0]]), angles, EXACT, np.array([0]), None)
    one = TURNS / 1e6 * (50e6 * 1.2 / 150e6) ** 5
    assert found[0, :, 1] == pytest.approx(np.full(3, one), rel=1e-2)  # 64 samples a turn


def test_criteria_are_those_of_the_tensor():
    rng = np.random.default_rng(2)
    stress = 1e8 * rng.standard_normal((6, 6, 50))
    stress[1], stress[2, 3:], stress[2, :3] = 0.0, 0.0, 1e8
    tensors = stress.transpose(0, 2, 1)
    signed = evaluate("signed von mises", tensors)
    assert signed_signals("signed von mises", stress) == pytest.approx(signed, abs=1.0)
    values = principal(tensors)
    greatest = np.where(values[..., 2] >= -values[..., 0], values[..., 2], values[..., 0])
    assert signed_signals("signed principal", stress) == pytest.approx(greatest, abs=1.0)
    rows = normal_stress_rows(np.array([[1.0, 0, 0], [0, np.sqrt(0.5), np.sqrt(0.5)]]))
    assert rows @ np.arange(1.0, 7.0) == pytest.approx([1.0, 0.5 * (2.0 + 3.0) + 5.0])


@pytest.fixture(scope="module")
def spread() -> tuple[np.ndarray, np.ndarray, Counting]:
    """More nodes than a block, more times than a block, two phases."""
    rng = np.random.default_rng(6)
    modes = rng.standard_normal((300, 6, 4)) * 1e6 * rng.random(300)[:, None, None] ** 3
    q = np.cumsum(rng.standard_normal((700, 4)), axis=0)
    phase = (np.arange(700) > 400).astype(np.int64)
    return modes, q, Counting(CURVE, (0.9,), phase)


def test_order_of_nodes_and_size_of_blocks_do_not_matter(spread):
    modes, q, counting = spread
    whole = recover_damage(modes, q, "signed von mises", counting, tolerance=None)
    for nodes in (np.random.default_rng(7).permutation(300), np.array([299, 3])):
        found = recover_damage(modes, q, "signed von mises", counting, nodes, None)
        np.testing.assert_allclose(found.damage, whole.damage[nodes], rtol=1e-9)
    assert (whole.damage.sum(axis=0) > 0.0).all()


def in_segments(monkeypatch, size):
    for module in (low_rank, damage, critical_plane, extremes):
        monkeypatch.setattr(module, "SEGMENT", size)


@pytest.mark.parametrize(("size", "tolerance"), [(256, 1e-4), (512, 1e-4), (64, None), (101, None)])
@pytest.mark.parametrize("negligible", [0.0, 1e-6])
def test_segments_change_neither_damage_nor_extremes(spread, monkeypatch, size, tolerance, negligible):
    modes, q, counting = spread
    counting = replace(counting, negligible=negligible)
    angles, nodes = np.radians([[0.0, 40.0, 80.0]] * 4), np.arange(4)
    normals = np.tile([0.0, 0.0, 1.0], (len(modes), 1))

    def found():
        of_scalar = recover_damage(modes, q, "signed von mises", counting, tolerance=tolerance)
        on_planes = damage_on_planes(modes, q, normals, angles, counting, nodes, tolerance)
        return of_scalar, on_planes, fem.recover_extremes(modes, q, tolerance=None)

    (whole, planes, most), _ = found(), in_segments(monkeypatch, size)
    parts, planes_in_parts, most_in_parts = found()
    np.testing.assert_allclose(parts.damage, whole.damage, rtol=1e-12, atol=0.0)
    np.testing.assert_allclose(planes_in_parts, planes, rtol=1e-12, atol=0.0)
    exact = {"rtol": 0.0 if size % 256 == 0 else 1e-12}
    for name in ("highest", "lowest", "valley", "peak"):
        np.testing.assert_allclose(getattr(parts.ends, name), getattr(whole.ends, name), **exact)
    for name in ("greatest", "least", "highest", "greatest_at", "highest_nodes"):
        np.testing.assert_allclose(getattr(most_in_parts, name), getattr(most, name), **exact)


class Repeated:
    """History that is never whole: blocks of random numbers, the same ones each time."""

    def __init__(self, blocks):
        self.blocks, self.shape = blocks, (500 * blocks, 4)

    def __iter__(self):
        return (np.random.default_rng(k).standard_normal((500, 4)) for k in range(self.blocks))


@pytest.mark.slow
def test_a_longer_history_takes_no_more_memory(spread, monkeypatch):
    """Turning points, cycles and stresses of four times the time are not in memory together."""
    in_segments(monkeypatch, 512)
    modes, peaks = spread[0], []
    for blocks in (4, 16):
        q = Repeated(blocks)
        counting = Counting(CURVE, (0.9,), np.zeros(q.shape[0], dtype=np.int64))
        tracemalloc.start()
        found = recover_damage(modes, q, "signed principal", counting)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert found.damage.sum() > 0.0
    assert peaks[1] < 1.1 * peaks[0]


def test_phases_share_what_the_whole_history_does(spread):
    modes, q, counting = spread
    parts = recover_damage(modes, q, "signed principal", counting, tolerance=None).damage
    whole = replace(counting, phase=np.zeros(700, dtype=np.int64))
    together = recover_damage(modes, q, "signed principal", whole, tolerance=None).damage
    assert parts.sum(axis=2) == pytest.approx(together.sum(axis=2), rel=1e-9)


def test_a_longer_run_of_the_same_cycle_does_as_much_a_pass(spread):
    modes, q, _ = spread
    one, three = (Counting(CURVE, (0.9,), np.zeros(k * 700, dtype=np.int64)) for k in (1, 3))
    first = recover_damage(modes, q, "signed von mises", one, tolerance=None).damage
    long = recover_damage(modes, np.tile(q, (3, 1)), "signed von mises", three, tolerance=None).damage
    assert long == pytest.approx(3.0 * first, rel=1e-9)


@pytest.mark.parametrize("miner", ["elementary", "haibach", "original"])
def test_what_is_left_out_first_does_no_more_than_it_may(spread, miner):
    modes, q, counting = spread
    counting = replace(counting, curve=replace(CURVE, miner=miner))
    exact = recover_damage(modes, q, "signed von mises", counting, tolerance=None)
    negligible = 1e-3 * exact.damage.sum(axis=2).max()
    short = replace(counting, negligible=negligible)
    found = recover_damage(modes, q, "signed von mises", short, tolerance=None)
    swing = 0.5 * (exact.ends.highest - exact.ends.lowest)
    assert 0.1 < (swing <= short.cut).mean() < 0.95  # whole nodes are left out, and not all
    lost = (exact.damage - found.damage).sum(axis=2)
    assert lost.min() >= -1e-12 * exact.damage.max()
    assert lost.max() <= negligible
    if miner == "original":
        # what lies below the endurance limit does nothing: leaving it out changes nothing at all
        np.testing.assert_allclose(found.damage, exact.damage, rtol=1e-12)


def test_a_reduced_rank_is_near_the_full_one(small):
    rng = np.random.default_rng(8)
    smooth = np.cumsum(rng.standard_normal((500, len(small.frequencies))), axis=0)
    q = 50.0 * smooth / (2 * np.pi * small.frequencies) ** 2
    nodes = small.mesh.surface_nodes
    counting = Counting(CURVE, (0.9,), np.zeros(500, dtype=np.int64))
    exact = recover_damage(small.stress_modes, q, "signed principal", counting, nodes, None)
    found = recover_damage(small.stress_modes, q, "signed principal", counting, nodes)
    assert np.abs(found.damage - exact.damage).max() <= 1e-2 * exact.damage.sum(axis=2).max()
    assert found.bound.max() > 0.0
    assert not exact.bound.any()


def test_normals_of_a_box_point_outward(cube):
    normals, skin = surface_normals(cube), cube.surface_nodes
    assert ((normals * (cube.nodes - 0.5)).sum(axis=1)[skin] > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(normals[skin], axis=1), 1.0, rtol=1e-6)
    inside, modes = np.setdiff1d(np.arange(len(cube.nodes)), skin)[:1], np.zeros((len(cube.nodes), 6, 1))
    with pytest.raises(ValueError, match="nodes must be on the surface"):
        damage_on_planes(modes, PHASE[:, None], normals, np.zeros((1, 1)), EXACT, inside)


def test_what_cannot_be_counted_is_refused(spread):
    modes, q, counting = spread
    refused("at least 3 times to hold a cycle, got 2", Counting, CURVE, (0.9,), np.zeros(2, dtype=np.int64))
    refused("phase must have 699 times", recover_damage, modes, q[1:], "signed principal", counting)
    refused("criterion must be one of", recover_damage, modes, q, "tresca", counting)
    refused("negligible must not be negative", replace, counting, negligible=-1.0)
    refused("survival must be inside", replace, counting, survivals=())
