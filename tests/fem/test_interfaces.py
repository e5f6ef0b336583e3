"""Spiders see rigid motion, and faulty ones are refused."""

import numpy as np
import pytest

import fem
from fem.interfaces import averaging_rows
from meshes import joint_interfaces
from tests.fem.bodies import beam_interfaces


def test_averaging_rows_see_a_rigid_motion() -> None:
    rng = np.random.default_rng(3)
    positions, center = rng.standard_normal((9, 3)), rng.standard_normal(3)
    translation, rotation = rng.standard_normal(3), rng.standard_normal(3)
    u = translation + np.cross(rotation, positions - center)
    rows = averaging_rows(positions, rng.random(9), center)
    np.testing.assert_allclose(rows @ u.ravel(), np.r_[translation, rotation], rtol=1e-10)


def test_faulty_interfaces(shoe: fem.ElasticBody) -> None:
    bores = joint_interfaces(shoe.mesh)
    with pytest.raises(ValueError, match="'empty': nodes must be at least one"):
        fem.Interface("empty", (0, 0, 0), [])
    with pytest.raises(ValueError, match="three finite numbers"):
        fem.Interface("odd", (0, np.nan, 0), [1, 2, 3])
    shared = fem.Interface("double", bores[0].center, bores[0].nodes[:5])
    with pytest.raises(ValueError, match=r"got .* in 'front right' and 'double'"):
        fem.Partition(shoe, [*bores, shared])
    ends = shoe.mesh.elements[0, [0, 1, 4]]
    with pytest.raises(ValueError, match="'line': nodes must not lie on a line"):
        fem.Partition(shoe, [fem.Interface("line", (0, 0, 0), ends)])
    with pytest.raises(ValueError, match=r"'far': nodes must lie in 0\.\."):
        fem.Partition(shoe, [fem.Interface("far", (0, 0, 0), [0, 1, 10**7])])
    with pytest.raises(ValueError, match="twice"):
        fem.Partition(shoe, [bores[0], bores[0]])


def test_loads_on_centres_are_placed_by_name(beam: fem.ElasticBody) -> None:
    ends = beam_interfaces(beam)
    loads = fem.center_loads(ends, {"right": [1.0, 2.0, 3.0]})
    np.testing.assert_array_equal(loads[:, 0], [0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0])
    with pytest.raises(KeyError, match=r"interfaces of \['left', 'right'\], got \['middle'\]"):
        fem.center_loads(ends, {"middle": [1.0, 0.0, 0.0]})
