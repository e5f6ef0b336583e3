"""Line contact: numbers of Hertz and Johnson, a strip of finite elements, edges, yield and shakedown."""

import numpy as np
import pytest
import skfem
from scipy.sparse.linalg import splu
from skfem.models.elasticity import lame_parameters, linear_elasticity, linear_stress

from fem.fatigue.line_contact import (
    DEPTHS,
    PLACES,
    LineContact,
    greatest_line_load,
    line_contact,
    path_stress,
    stress_below,
    tilted_moment,
)

MODULUS, POISSON, RADIUS = 200e9, 0.3, 0.4
PLANE = MODULUS / (1.0 - POISSON**2) / 2.0
LOAD = 574e3 / 0.18
CORE = 690e6


def test_numbers_of_a_roller_by_hand():
    """p0 = sqrt(q E* / (pi R)), and the pressure's integral pi p0 a / 2 is the load."""
    contact = line_contact(LOAD, RADIUS, PLANE)
    assert contact.pressure == pytest.approx(528.1e6, rel=1e-3)
    assert contact.half_width == pytest.approx(2.0 * LOAD / np.pi / contact.pressure)


def test_stress_below_has_johnsons_extremes():
    """Shear 0.300 p0 at 0.786 a below the middle; 0.250 p0 along the surface, 0.5 a deep and 0.87 a aside."""
    z = np.linspace(0.0, 3.0, 3001)
    xx, yy, zz, xz = stress_below(0.0, z, POISSON).T
    shear = 0.5 * (xx - zz)
    assert (shear.max(), z[shear.argmax()]) == pytest.approx((0.300, 0.786), abs=1e-3)
    assert np.abs(xz).max() == 0.0
    mises = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2))
    assert (mises.max(), z[mises.argmax()]) == pytest.approx((0.558, 0.704), abs=2e-3)
    x = np.linspace(-2.0, 2.0, 401)
    along = stress_below(x, z[:2000, None], POISSON)[..., 3]
    row, column = np.unravel_index(np.abs(along).argmax(), along.shape)
    assert np.abs(along).max() == pytest.approx(0.25, abs=1e-4)
    assert (z[row], abs(x[column])) == pytest.approx((0.5, 0.866), abs=0.01)
    on_top = stress_below(x, 0.0, POISSON)
    np.testing.assert_allclose(on_top[:, 2], -np.sqrt(np.maximum(1.0 - x**2, 0.0)), atol=1e-12)


def test_stress_below_is_in_equilibrium():
    x, z, h = np.array([0.3, 0.9, 1.7, -1.2]), np.array([0.4, 0.8, 0.3, 1.1]), 1e-5
    by_x = (stress_below(x + h, z, POISSON) - stress_below(x - h, z, POISSON)) / (2.0 * h)
    by_z = (stress_below(x, z + h, POISSON) - stress_below(x, z - h, POISSON)) / (2.0 * h)
    np.testing.assert_allclose(by_x[:, 0] + by_z[:, 3], 0.0, atol=1e-8)
    np.testing.assert_allclose(by_x[:, 3] + by_z[:, 2], 0.0, atol=1e-8)


def pressed_strip(load: float) -> tuple[float, float, np.ndarray, np.ndarray]:
    """Rigid roller on half of an elastic strip: pressure, half width, and (xx - zz) / 2 below its middle.

    Elements have a twentieth of the expected half width; the strip is a thousand of these wide and deep.
    """
    expected = line_contact(load, RADIUS, 2.0 * PLANE)
    near = np.linspace(0.0, 2.0, 41)
    far = 2.0 + np.cumsum(0.05 * 1.2 ** np.arange(1, 51))
    lines = expected.half_width * np.concatenate((near, far[far < 1000.0]))
    mesh = skfem.MeshQuad.init_tensor(lines, -lines[::-1])
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()))
    lame = lame_parameters(MODULUS, POISSON)
    stiffness = linear_elasticity(*lame).assemble(basis)
    sides = basis.get_dofs(lambda x: x[0] == 0.0).all("u^1")
    bottom = basis.get_dofs(lambda x: x[1] == x[1].min()).all("u^2")
    free = np.setdiff1d(np.arange(basis.N), np.concatenate((sides, bottom)))
    touched = np.flatnonzero((mesh.p[1] == 0.0) & (mesh.p[0] <= lines[40]))
    touched = touched[np.argsort(mesh.p[0, touched])]
    x, rows = mesh.p[0, touched], basis.nodal_dofs[1, touched]
    unit = np.zeros((basis.N, len(rows)))
    unit[rows, np.arange(len(rows))] = -1.0
    solver = splu(stiffness[free][:, free].tocsc())
    answers = np.zeros_like(unit)
    answers[free] = solver.solve(unit[free])
    down, gap = -answers[rows], x**2 / (2.0 * RADIUS)
    active = x < expected.half_width
    for _ in range(30):
        n = int(active.sum())
        balance = np.ones((n, 1))
        system = np.block([[down[np.ix_(active, active)], -balance], [balance.T, np.zeros((1, 1))]])
        solution = np.linalg.solve(system, np.append(-gap[active], 0.5 * load))
        forces = np.zeros(len(x))
        forces[active] = solution[:n]
        left = gap - solution[n] + down @ forces
        changed = np.where(active, forces > 0.0, left < 0.0)
        if (changed == active).all():
            break
        active = changed
    shares = np.gradient(x)
    shares[0] *= 0.5
    pressure = forces / shares
    squares = np.polyfit(x[active][:-2] ** 2, pressure[active][:-2] ** 2, 1)
    moved = basis.interpolate(answers @ forces)
    stress = np.asarray(linear_stress(*lame)(0.5 * (moved.grad + np.swapaxes(moved.grad, 0, 1))))
    middle = stress.mean(axis=-1)
    center = mesh.p[:, mesh.t].mean(axis=1)
    column = np.flatnonzero(center[0] == center[0].min())
    shear, half_width = 0.5 * (middle[0, 0] - middle[1, 1])[column], np.sqrt(-squares[1] / squares[0])
    return np.sqrt(squares[1]), half_width, -center[1, column], shear


def test_a_pressed_strip_of_finite_elements_has_hertz_pressure_and_shear():
    """Pressure, half width and the shear below within 2 %; its depth within an element."""
    expected = line_contact(LOAD, RADIUS, 2.0 * PLANE)
    pressure, half_width, depth, shear = pressed_strip(LOAD)
    assert pressure == pytest.approx(expected.pressure, rel=0.02)
    assert half_width == pytest.approx(expected.half_width, rel=0.02)
    closed = stress_below(0.025, depth / expected.half_width, POISSON)
    near = depth < 2.0 * expected.half_width
    below = 0.5 * (closed[near, 0] - closed[near, 2])
    np.testing.assert_allclose(shear[near] / expected.pressure, below, atol=0.02 * 0.3)
    assert depth[shear.argmax()] / expected.half_width == pytest.approx(0.786, abs=0.05)


def test_edges_of_an_uneven_contact():
    force, width = 6e5, 0.18
    q = force / width
    assert greatest_line_load(force, 0.0, width) == pytest.approx(q)
    assert greatest_line_load(force, force * width / 6.0, width) == pytest.approx(2.0 * q)
    # all on one of two strips at the Gauss points
    at_points = greatest_line_load(force, -force * width / np.sqrt(12.0), width)
    assert at_points == pytest.approx(3.155 * q, rel=1e-3)
    arms = np.linspace(0.0, 0.45, 50) * width
    assert (np.diff(greatest_line_load(np.full(50, force), force * arms, width)) > 0.0).all()
    assert greatest_line_load(0.0, 0.0, width) == 0.0


def test_tilt_moves_the_load_to_an_edge():
    """By Palmgren 574 kN over 0.18 m approach by 0.092 mm: 0.92 mrad takes twice that off one edge."""
    force, width = 574e3, 0.18
    approach = 3.84e-5 * force**0.9 / 180.0**0.8 * 1e-3
    assert approach == pytest.approx(0.0919e-3, rel=2e-3)
    lifts = 2.0 * 0.9 * approach / width
    assert tilted_moment(force, lifts, width) == pytest.approx(force * width / 6.0)
    assert tilted_moment(force, 0.25 * lifts, width) == pytest.approx(0.25 * force * width / 6.0)
    assert tilted_moment(force, 1.001 * lifts, width) == pytest.approx(force * width / 6.0, rel=2e-3)
    assert force * width / 6.0 < tilted_moment(force, 10.0 * lifts, width) < force * width / 2.0


def test_yield_and_shakedown_are_johnsons():
    """First yield at 3.1 k, shakedown up to 4 k, whatever the strength."""
    contact = line_contact(LOAD, RADIUS, PLANE)
    for strength in (250e6, CORE):
        found = path_stress(contact, strength, POISSON)
        k = strength / np.sqrt(3.0)
        assert found.to_yield * contact.pressure == pytest.approx(3.10 * k, rel=5e-3)
        assert found.to_shakedown * contact.pressure == pytest.approx(4.0 * k, rel=5e-3)
        assert found.shear == pytest.approx(0.300 * contact.pressure, rel=2e-3)
        assert found.depth == pytest.approx(0.786 * contact.half_width, rel=0.02)


def test_stress_of_the_structure_is_superposed():
    contact = line_contact(LOAD, RADIUS, PLANE)
    alone = path_stress(contact, CORE, POISSON)

    def beside(*rows: tuple[float, float, float]):
        return path_stress(contact, CORE, POISSON, 1e6 * np.array(rows))

    # tension within the surface adds to the pressure's shear, compression relieves
    assert beside((100.0, 100.0, 0.0)).to_yield < alone.to_yield < beside((-100.0, -100.0, 0.0)).to_yield
    # residual stress takes up what comes and goes with the roller, as far as it alone shakes down
    taken_up = beside((60.0, 80.0, 0.0), (-40.0, 50.0, 0.0))
    assert taken_up.to_shakedown == pytest.approx(alone.to_shakedown, rel=5e-3)
    assert beside((400.0, 0.0, 0.0), (-400.0, 0.0, 0.0)).to_shakedown < 0.8 * alone.to_shakedown
    # without a roller a range of stress shakes down up to twice the yield strength
    for least, times in ((-CORE, 1.0), (0.0, 2.0)):
        stresses = np.array([(CORE, 0.0, 0.0), (least, 0.0, 0.0)])
        found = path_stress(LineContact(1.0, 1e-3), CORE, POISSON, stresses)
        assert found.to_shakedown == pytest.approx(times, rel=5e-3)
    assert 0.0 in PLACES
    assert DEPTHS[0] == 0.0
