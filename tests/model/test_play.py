"""Pins with play: no force within it, closed forms of a pressed pin, tangent, balances, energy, wear."""

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile, simulate
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.joints.pin import ROWS
from exudyn_crawler.results.balance import energy_balance, shoe_actions, shoe_imbalance
from tests.model.both import compiled_matrix, residual_of

pytestmark = pytest.mark.simulation

RADIAL, AXIAL, STIFFNESS, EDGE = 2e-3, 1e-3, 5e9, 1e-5
PLAY = {"radial": RADIAL, "axial": AXIAL, "stiffness": STIFFNESS, "damping": 1e6}


def forces_of_play(system, q, q_t):
    """Multipliers of all links with play at a state, zero for all others."""
    return system.forces_of_play(np.stack((q, q_t, np.zeros_like(q))), system.inputs(0.0))


class Link:
    """First link of a closed chain, both shoes level and nothing else moved."""

    def __init__(self):
        self.case = Case.closed().with_({"gear.play": PLAY})
        self.system = compiled_system(self.case)
        self.size = self.system.layout.coordinate_count
        self.plays = self.system.tables.joints.plays
        self.rows = slice(self.size + self.plays.first, self.size + self.plays.first + ROWS)

    def laws(self, gap=(0.0, 0.0, 0.0), angles=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 0.0)):
        """Multipliers of the link with the front shoe moved off its pin (m), turned (rad), and moving."""
        bodies = self.system.tables.bodies
        rear, front = self.system.tables.markers.body[self.plays.markers[0]]
        at = self.system.tables.markers.position[self.plays.markers[0]]
        q, q_t = np.zeros((2, self.size))
        first = bodies.coordinate[front]
        turn = bodies.reference[front, 3:] + angles
        q[first + 3 : first + 6] = angles
        pin = bodies.reference[rear, :3] + rotation_matrices(bodies.reference[rear, 3:]) @ at[0]
        q[first : first + 3] = pin + gap - bodies.reference[front, :3] - rotation_matrices(turn) @ at[1]
        q_t[first : first + 3] = rate
        return forces_of_play(self.system, q, q_t)[self.plays.first :][:ROWS]


@pytest.fixture(scope="module")
def link():
    return Link()


def test_no_force_within_the_play(link):
    half = link.plays.half[0]
    assert not link.laws((0.9 * RADIAL, 0.9 * AXIAL, 0.0)).any()
    assert not link.laws((0.0, 0.0, -0.9 * RADIAL), rate=(1.0, 1.0, 1.0)).any()
    assert not link.laws(angles=(0.0, 0.0, 0.9 * RADIAL / half)).any()


def test_pressed_pin_has_the_penetration_of_its_force(link):
    """Both pins bear half of a force; faces bear a side force. The edge adds half its depth."""
    force = 1e6
    depth = force / (2.0 * STIFFNESS) + 0.5 * EDGE
    way = np.array([0.6, 0.0, -0.8])
    laws = link.laws((RADIAL + depth) * way)
    np.testing.assert_allclose(laws, [*force * way, 0.0, 0.0], rtol=1e-7, atol=1.0)
    laws = link.laws((0.0, -AXIAL - force / STIFFNESS - 0.5 * EDGE, 0.0))
    np.testing.assert_allclose(laws, [0.0, -force, 0.0, 0.0, 0.0], rtol=1e-9)


@pytest.mark.parametrize("part", [1e-6, 0.5, 1.0 - 1e-9, 1.0 + 1e-9])
def test_stiffness_of_a_contact_rises_linearly_at_its_edge(link, part):
    """Force and stiffness do not jump at the surface, nor where both are full."""
    depth = part * EDGE
    force = -link.laws((0.0, -AXIAL - depth, 0.0))[1]
    assert force == pytest.approx(0.5 * STIFFNESS * depth * part, rel=1e-6, abs=1e-9)


def test_one_pin_takes_all_of_a_force_that_turns_the_link(link):
    """A yaw that lifts one pin off leaves a moment of the force times half the distance of the pins."""
    half = link.plays.half[0]
    lifted, depth = 2e-4, 2e-4
    yaw = (lifted + depth) / (2.0 * half)
    laws = link.laws((RADIAL + 0.5 * (depth - lifted), 0.0, 0.0), angles=(0.0, 0.0, yaw))
    assert laws[0] == pytest.approx(STIFFNESS * (depth - 0.5 * EDGE), rel=1e-3)
    assert abs(laws[3]) == pytest.approx(half * laws[0], rel=1e-4)


def test_damping_resists_the_approach_and_never_pulls(link):
    pressed = np.array([RADIAL + 1e-4, 0.0, 0.0])
    still = link.laws(pressed)[0]
    assert link.laws(pressed, rate=(0.1, 0.0, 0.0))[0] == pytest.approx(still + 2.0 * 1e6 * 0.1)
    assert link.laws(pressed, rate=(-10.0, 0.0, 0.0))[0] == 0.0


def moved(system, seed):
    """Coordinates and rates of a chain whose pins are pressed at random."""
    rng = np.random.default_rng(seed)
    q = system.first_guess()
    shoes = 6 * system.case.track.shoe_count
    q[:shoes] += np.tile([3e-3, 3e-3, 3e-3, 2e-3, 2e-3, 2e-3], shoes // 6) * rng.normal(size=shoes)
    return q, 0.05 * rng.normal(size=len(q))


def test_tangent_is_the_derivative_of_the_laws(link):
    system = link.system
    q, q_t = moved(system, 3)
    weights = (1.0, 900.0, 9e5, False, 1e-3)
    rows = slice(link.rows.start, link.rows.start + ROWS * len(link.plays.half))
    law = forces_of_play(system, q, q_t)
    matrix = compiled_matrix(system, q, q_t, weights, law)[rows, : link.size]
    rng = np.random.default_rng(4)
    for _ in range(5):
        way = 1e-9 * rng.normal(size=link.size)
        ends = [forces_of_play(system, q + s * way, q_t + s * 900.0 * way) for s in (1.0, -1.0)]
        expected = 0.5 * (ends[1] - ends[0])[rows.start - link.size : rows.stop - link.size]
        np.testing.assert_allclose(matrix @ way, expected, rtol=0.0, atol=1e-4 * np.abs(expected).max())


def test_row_of_a_law_is_zero_at_its_force_alone(link):
    """Wherever the law is linearized, and its derivative by the multiplier is one there."""
    system = link.system
    q, q_t = moved(system, 8)
    law = forces_of_play(system, q, q_t)
    rows = slice(link.rows.start, link.rows.start + ROWS * len(link.plays.half))
    at_law = residual_of(system, q, q_t, multipliers=law)[rows]
    np.testing.assert_allclose(at_law, 0.0, atol=1e-9 * np.abs(law).max())
    off = np.random.default_rng(9).normal(size=len(law))
    for scale in (10.0, -10.0):
        left = residual_of(system, q, q_t, multipliers=law + scale * off)[rows]
        expected = scale * off[rows.start - link.size : rows.stop - link.size]
        np.testing.assert_allclose(left, expected, rtol=1e-2, atol=1e-2)


def test_energy_of_pressed_pins_is_a_potential_and_their_damping_takes_work(link):
    """Without rates forces have symmetric derivatives; what rates add to them does no positive work."""
    system = link.system
    q, q_t = moved(system, 6)
    n = link.size
    rows = slice(link.rows.start, link.rows.start + ROWS * len(link.plays.half))
    law = forces_of_play(system, q, np.zeros(n))
    matrix = compiled_matrix(system, q, np.zeros(n), (1.0, 0.0, 0.0, False, 1e-3), law)
    stiffness = matrix[:n, rows] @ matrix[rows, :n]
    np.testing.assert_allclose(stiffness, stiffness.T, rtol=0.0, atol=1e-9 * np.abs(stiffness).max())
    added = (forces_of_play(system, q, q_t) - law)[rows.start - n : rows.stop - n]
    assert added @ matrix[:n, rows].T @ q_t > 0.0


def test_forces_and_moments_of_links_are_in_balance(link):
    """Though pins are off their bores' middles."""
    system = link.system
    q, q_t = moved(system, 5)
    none = residual_of(system, q, q_t)
    multipliers = forces_of_play(system, q, q_t)
    bodies = system.tables.bodies
    count = system.case.track.shoe_count
    total, about, greatest = np.zeros(3), np.zeros(3), 0.0
    chain = slice(link.plays.first, link.plays.first + ROWS * len(link.plays.half))
    alone = multipliers.copy()
    alone[: chain.start] = alone[chain.stop :] = 0.0
    shoes = (residual_of(system, q, q_t, None, alone) - none)[: 6 * count].reshape(-1, 6)
    for k in range(count):
        roll, _, yaw = bodies.reference[k, 3:] + q[6 * k + 3 : 6 * k + 6]
        axes = np.array(
            [
                [np.cos(yaw), np.sin(yaw), 0.0],
                [-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)],
                [0.0, 0.0, 1.0],
            ]
        )
        moment = np.linalg.solve(axes, shoes[k, 3:])
        total += shoes[k, :3]
        place = bodies.reference[k, :3] + q[6 * k : 6 * k + 3]
        about += moment + np.cross(place, shoes[k, :3])
        greatest = max(greatest, np.abs(shoes[k]).max())
    assert greatest > 1e6
    np.testing.assert_allclose(total, 0.0, atol=1e-8 * greatest)
    np.testing.assert_allclose(about, 0.0, atol=1e-7 * greatest)


@pytest.fixture(scope="module")
def driven():
    """Chain with play that rises to 0.3 m/s, stored at every step; soft bores store and lose more."""
    rise = StepProfile(times=(0.0, 0.3), values=(0.0, 0.3))
    steps = {"solver.step": 1e-3, "solver.output_interval": 1e-3}
    case = Case.closed().with_(steps | {"drive.speed": rise})
    case = case.with_({"gear.play": PLAY | {"stiffness": 5e8, "damping": 1e7}})
    return simulate(case, 0.5, progress=False)


def test_all_that_acts_on_shoes_is_the_rate_of_their_momentum(driven):
    """The force of a link acts at one point on both shoes, off the bore of the shoe in front."""
    acts, left = shoe_actions(driven), shoe_imbalance(driven)
    for name, parts in acts.items():
        assert float(abs(left[name]).max()) < 1e-5 * float(abs(parts).max()), name


def test_work_of_the_torque_is_losses_and_what_is_stored(driven):
    balance = energy_balance(driven)
    work = balance.drive.values.max()
    assert np.abs(balance.imbalance.values).max() < 1e-3 * work
    # each is some times more than what may be left open
    for name in ("pin_losses", "pin_springs"):
        assert float(balance[name][-1]) > 1e-2 * work, name


def test_stored_energy_is_the_potential_of_forces_at_rest(link):
    """Its derivative along a way of all shoes is the work of the forces of play along it."""
    system = link.system
    q, _ = moved(system, 11)
    still = np.zeros(link.size)
    rows = slice(link.rows.start, link.rows.start + ROWS * len(link.plays.half))
    law = forces_of_play(system, q, still)
    matrix = compiled_matrix(system, q, still, (1.0, 0.0, 0.0, False, 1e-3), law)
    along = matrix[: link.size, rows] @ law[rows.start - link.size : rows.stop - link.size]
    way = 1e-8 * np.random.default_rng(12).normal(size=link.size)
    both = np.stack((q - way, q + way))
    energy = system.gear_forces(np.zeros(2), both, np.zeros_like(both)).energy[:, 2]
    assert energy[0] > 1e3
    assert energy[1] - energy[0] == pytest.approx(2.0 * along @ way, rel=1e-5)


def test_play_from_wear_is_what_the_pitch_has_grown():
    new = Case.closed()
    worn = {"gear.pitch_growth": 0.002, "gear.idler.slack": 0.0}
    play = PLAY | {"radial": None}
    ideal, with_play = new.with_(worn), new.with_(worn | {"gear.play": play})
    chain = new.track
    assert with_play.gear.pin_clearance(chain) == pytest.approx(0.002 * chain.pitch)
    assert with_play.gear.chain_pitch(chain) == ideal.gear.chain_pitch(chain)
    assert with_play.gear.shoe_pitch(chain) == pytest.approx(chain.pitch)
    with pytest.raises(ParameterError, match=r"play\.radial must be given with a pitch_growth"):
        new.with_({"gear.pitch_growth": -0.001, "gear.play": play})
