"""Elements against formulas: patch test, rigid bodies, rods, beams, cylinders and holes."""

import gc
import weakref

import numpy as np
import pytest

import fem
from benchmarks.fem_accuracy import OVERHANG, TIP_LOAD, bending
from fem.body.elasticity import MASS_ORDER, scalar_basis
from fem.body.element_stress import von_mises
from fem.body.solver import factorized
from meshes import STEEL
from tests.fem.bodies import box_mesh, tube
from tests.fem.refusals import refused


@pytest.mark.parametrize("order", [1, 2])
def test_patch(order):
    mesh = box_mesh((2, 2, 2), (1.0, 0.7, 0.5), order=order)
    rng = np.random.default_rng(1)
    inner = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.surface_nodes)
    nodes = mesh.nodes.copy()
    if order == 1:
        nodes[inner] += 0.05 * rng.standard_normal((len(inner), 3))
    body = fem.ElasticBody(fem.Mesh(nodes, mesh.elements, {}), STEEL)
    gradient = 1e-4 * rng.standard_normal((3, 3))
    u = nodes @ gradient
    forces = (body.stiffness @ u.ravel()).reshape(-1, 3)
    assert np.abs(forces[inner]).max() < 1e-12 * np.abs(forces).max()  # rounding
    strain = (gradient + gradient.T) / 2
    lam, mu = STEEL.lame
    expected = lam * np.trace(strain) * np.eye(3) + 2 * mu * strain
    components = expected[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]][None]
    stress = body.stress(u[:, :, None])[:, :, 0] - components
    assert np.abs(stress).max() < 1e-10 * np.abs(expected).max()


def test_rigid_properties_of_a_box():
    a, b, c = 1.2, 0.7, 0.4
    body = fem.ElasticBody(box_mesh((2, 2, 1), (a, b, c)), STEEL)
    mass = STEEL.density * a * b * c
    assert body.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(body.center_of_mass, [a / 2, b / 2, c / 2], rtol=1e-12)
    expected = mass / 12 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    np.testing.assert_allclose(body.inertia, expected, atol=1e-11 * mass)


def test_mass_of_curved_elements_converges_at_fourth_order():
    def error(n: int) -> float:
        mesh = box_mesh((1, n, 1), (1.0, 1.0, 1.0), tube(1.0, 2.0, np.pi / 2))
        return abs(fem.ElasticBody(mesh, STEEL).mass / STEEL.density - np.pi / 4 * 3.0)

    # a quadratic edge misses an arc by O(h^4), its area included
    assert np.log2(error(3) / error(6)) == pytest.approx(4.0, abs=0.3)


def test_rod_frequencies_converge_at_fourth_order():
    material = fem.Material(200e9, 0.0, 8000.0)  # without Poisson's ratio a rod is exact in 1-D
    speed = np.sqrt(200e9 / 8000.0)

    def error(n: int) -> float:
        found = fem.ElasticBody(box_mesh((n, 1, 1), (2.0, 0.2, 0.2)), material).natural_frequencies(60)
        return float(np.min(np.abs(found / (2 * speed / (2 * 2.0)) - 1.0)))

    assert np.log2(error(4) / error(8)) == pytest.approx(4.0, abs=0.5)


def test_slender_beam_bends_at_eulers_frequency():
    length, depth = 2.0, 0.04
    found = fem.ElasticBody(box_mesh((24, 1, 1), (length, depth, depth)), STEEL).natural_frequencies(8)[6:]
    expected = 4.730041**2 / (2 * np.pi * length**2) * depth * np.sqrt(200e9 / (12 * 7847.25))
    # Timoshenko's shear and rotary inertia take 0.2 % off at this slenderness
    np.testing.assert_allclose(found, expected, rtol=4e-3)


def solve_held(body: fem.ElasticBody, held: dict[int, float], forces: np.ndarray) -> np.ndarray:
    """Displacements (n, 3) with given degrees of freedom prescribed."""
    k = body.stiffness
    dofs = np.array(sorted(held))
    u = np.zeros(k.shape[0])
    u[dofs] = [held[d] for d in dofs]
    free = np.setdiff1d(np.arange(len(u)), dofs)
    u[free] = factorized(k[free][:, free])((forces.ravel() - k @ u)[free])
    return u.reshape(-1, 3)


def symmetric(mesh: fem.Mesh, width: float) -> dict[int, float]:
    """Degrees of freedom that symmetry about x = 0 and y = 0 holds, and plane strain of this width."""
    planes = ((0, 0.0), (1, 0.0), (2, 0.0), (2, width))
    nodes = [(np.flatnonzero(np.abs(mesh.nodes[:, axis] - at) < 1e-9), axis) for axis, at in planes]
    return {3 * int(node) + axis: 0.0 for found, axis in nodes for node in found}


def test_thick_walled_cylinder():
    inner, outer, pressure = 1.0, 2.0, 1e6
    mesh = box_mesh((5, 6, 1), (1.0, 1.0, 0.2), tube(inner, outer, np.pi / 2))
    body = fem.ElasticBody(mesh, STEEL)
    radius = np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1])
    bore = mesh.boundary[(np.abs(radius[mesh.boundary] - inner) < 1e-9).all(axis=1)]
    weights = body.surface_weights(bore)
    radial = np.column_stack([mesh.nodes[:, 0], mesh.nodes[:, 1], 0 * radius]) / radius[:, None]
    u = solve_held(body, symmetric(mesh, 0.2), pressure * weights[:, None] * radial)
    stress = body.stress(u[:, :, None])[:, :, 0]
    side = np.abs(mesh.nodes[:, 1]) < 1e-9  # on the x axis the hoop stress is yy
    r = mesh.nodes[side, 0]
    constant = pressure * inner**2 / (outer**2 - inner**2)
    hoop, radial_stress = constant * (1 + outer**2 / r**2), constant * (1 - outer**2 / r**2)
    # nodal recovery is of second order: five elements through the wall leave 3 % at the bore
    np.testing.assert_allclose(stress[side, 1], hoop, atol=0.03 * hoop.max())
    np.testing.assert_allclose(stress[side, 0], radial_stress, atol=0.03 * hoop.max())
    nu, e = 0.3, 200e9
    moved = (1 + nu) / e * constant * ((1 - 2 * nu) * r + outer**2 / r)
    np.testing.assert_allclose(u[side, 0], moved, rtol=2e-3)


def test_kirsch_hole():
    """Stress concentration 3 at a round hole; the far edge moves as Kirsch's solution says."""
    a, far, pull = 1.0, 6.0, 1e6
    mesh = box_mesh((12, 12, 1), (1.0, 1.0, 0.2), tube(a, far, np.pi / 2, graded=True))
    body = fem.ElasticBody(mesh, STEEL)
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    mu, kappa = STEEL.lame[1], 3 - 4 * 0.3
    ux = r / a * (kappa + 1) * np.cos(angle) + 2 * a / r * (1 + kappa) * np.cos(angle)
    ux += 2 * (a / r - (a / r) ** 3) * np.cos(3 * angle)
    uy = r / a * (kappa - 3) * np.sin(angle) + 2 * a / r * (1 - kappa) * np.sin(angle)
    uy += 2 * (a / r - (a / r) ** 3) * np.sin(3 * angle)
    edge = np.flatnonzero(r > far * (1 - 1e-6))
    scale = pull * a / 8 / mu
    moved = {3 * node: scale * ux[node] for node in edge} | {3 * node + 1: scale * uy[node] for node in edge}
    u = solve_held(body, moved | symmetric(mesh, 0.2), np.zeros_like(mesh.nodes))
    stress = body.stress(u[:, :, None])[:, :, 0]
    top = (np.abs(x) < 1e-9) & (r < a * (1 + 1e-6))
    side = (np.abs(y) < 1e-9) & (r < a * (1 + 1e-6))
    # 12 graded elements along the radius leave 2 % in the extrapolated edge stress
    np.testing.assert_allclose(stress[top, 0], 3 * pull, rtol=0.02)
    np.testing.assert_allclose(stress[side, 1], -pull, rtol=0.06)


def test_von_mises_of_known_states():
    states = np.array([[2.0, 0, 0, 0, 0, 0], [5, 5, 5, 0, 0, 0], [0, 0, 0, 1, 0, 0.0]])
    np.testing.assert_allclose(von_mises(states), [2.0, 0.0, np.sqrt(3.0)], atol=1e-14)


@pytest.mark.parametrize("ratio", [0.5, -1.0, 0.7, float("nan")])
def test_poissons_ratio_out_of_range(ratio):
    refused("poissons_ratio", fem.Material, 200e9, ratio, 7850.0)


@pytest.mark.parametrize("order", [1, 2])
def test_what_maps_elements_goes_with_their_basis(order):
    """Hundreds of MB of a shoe's mesh, which would otherwise stay until Python looks for circles."""
    mesh = box_mesh((2, 2, 2), (1.0, 0.7, 0.5), order=order)
    gc.disable()
    try:
        basis = scalar_basis(mesh, MASS_ORDER[order])
        mapping = weakref.ref(basis.mapping)
        del basis
        assert mapping() is None
    finally:
        gc.enable()


def test_a_flange_is_stiff_by_long_elements_and_not_by_few_layers():
    """The shoe's flange beside its web: layers through it, and lengths along it, of quadratic elements."""
    frequency, stress, deflection = zip(
        *(bending(edge, layers) for edge, layers in ((0.033, 3), (0.033, 1), (0.066, 1), (0.132, 1))),
        strict=True,
    )
    stiffer = np.array(frequency) / frequency[0] - 1.0
    assert (stiffer[1:] > 0.0).all()
    assert stiffer[1:] == pytest.approx([0.015, 0.040, 0.152], rel=0.1)
    assert (np.diff(deflection) < 0.0).all()
    # a beam's under the load of its end, in the middle of its length
    width, thickness = OVERHANG[1:]
    beam = 0.5 * OVERHANG[0] * -TIP_LOAD[2] * 6.0 / (width * thickness**2)
    assert stress[0] == pytest.approx(beam, rel=0.05)
