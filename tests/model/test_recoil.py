"""Idler on a recoil spring: it stands still below the preload and gives way beyond it, up to its stroke."""

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile, simulate
from exudyn_crawler.case import Drive
from exudyn_crawler.case.parameters.closed_track import SETTLING, Recoil, Tensioner
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.equations import STIFFNESS
from exudyn_crawler.results.balance import energy_balance, frame_imbalance
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from tests.model.both import residual_of
from tests.states import row_of

pytestmark = pytest.mark.simulation

STIFF = 2e8
"""N/m: millimetres under the pull of the chain."""


def taut():
    """A chain on posts that pulls hard on its idler, on shims 2 mm back from where it just closes."""
    case = Case.closed().with_({"gear.support": "posts"})
    return case.with_({"gear.idler.take_up": case.gear.assembled(case).take_up - 2e-3})


def rest_of(case):
    system = compiled_system(case)
    return system_history(system, row_of(system.layout, {"coordinates": static_equilibrium(case)})[None])


def push_of(history):
    """Push of the chain on the idler, back along the frame, N."""
    return -history.wheel_force.sel(wheel="idler", axis="x").item()


def sprung(preload, stroke=0.1, stiffness=STIFF):
    recoil = Recoil(mass=8e3, stiffness=stiffness, preload=preload, stroke=stroke)
    return taut().with_({"gear.idler.recoil": recoil})


@pytest.fixture(scope="module")
def shims():
    return rest_of(taut())


@pytest.mark.slow
def test_idler_stands_still_below_the_preload_as_on_shims(shims):
    rest = rest_of(sprung(1.2 * push_of(shims)))
    assert rest.take_up.item() == pytest.approx(shims.take_up.item(), abs=1e-12)
    # what still creeps at rest is some ten N
    np.testing.assert_allclose(rest.joint_force, shims.joint_force, rtol=0.0, atol=1e-4 * push_of(shims))


@pytest.mark.slow
def test_idler_gives_way_by_what_exceeds_the_preload_over_the_stiffness(shims):
    preload = 0.6 * push_of(shims)
    rest = rest_of(sprung(preload))
    back = shims.take_up.item() - rest.take_up.item()
    assert back > 1e-4
    assert back == pytest.approx((push_of(rest) - preload) / STIFF, rel=1e-4)


@pytest.mark.slow
def test_idler_stands_at_the_end_of_its_stroke_where_the_chain_pushes_harder(shims):
    preload = 0.3 * push_of(shims)
    rest = rest_of(sprung(preload, stroke=1e-3, stiffness=1e7))
    assert shims.take_up.item() - rest.take_up.item() == pytest.approx(1e-3, abs=1e-9)
    assert push_of(rest) > preload + 1e7 * 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("preload", "stiffness"), [(1.0e6, 1e8), (1.2e6, 2e7)], ids=["stiff", "soft"])
def test_work_of_the_drive_is_what_spring_and_damper_store_and_take(preload, stiffness):
    """On the ground, up to 0.3 m/s: the chain pushes the idler back, the spring returns it."""
    recoil = Recoil(mass=8e3, stiffness=stiffness, preload=preload, stroke=0.1, damping=0.01 * stiffness)
    speed = Drive(speed=StepProfile(times=(0.0, 0.3), values=(0.0, 0.3)))
    history = simulate(
        Case.closed().with_({"gear.idler.recoil": recoil}).with_(drive=speed), 0.6, progress=False
    )
    back = history.take_up.values[0] - history.take_up.values
    assert 5e-3 < back.max() < 0.1
    assert back.min() > -1e-4
    balance = energy_balance(history)
    assert np.abs(balance.imbalance.values).max() < 2e-3 * balance.drive.values.max()
    assert balance.tensioners.values.max() > 0.05 * balance.drive.values.max()
    assert np.abs(frame_imbalance(history).heave.values[10:]).max() < 1e-3 * 9.81 * history.case.gear.mass


class Row:
    """Row of a recoil spring of an idler in a chain on posts."""

    def __init__(self, recoil):
        self.recoil = recoil
        case = Case.closed().with_({"gear.support": "posts", "gear.idler.recoil": recoil})
        self.system = compiled_system(case)
        self.count = self.system.layout.coordinate_count
        self.multiplier = self.system.layout.first_multiplier("bearing of the idler")

    def residual(self, place, multiplier, speed=0.0):
        """Residual with the idler at a place ahead (m), a multiplier (N) and a speed (m/s)."""
        q = np.zeros(self.count)
        q[-6] = place
        rates = np.zeros(self.count)
        rates[-6] = speed
        multipliers = np.zeros(self.system.tables.multipliers)
        multipliers[self.multiplier] = multiplier
        return residual_of(self.system, q, rates, None, multipliers)[self.count + self.multiplier]


@pytest.mark.parametrize(
    ("push", "stands", "springs"),
    [(0.9, 0.0, False), (1.5, -1.0, True), (2.5, -1.0, False)],
    ids=["below the preload", "on the spring", "at the stop"],
)
def test_row_of_a_recoil_spring_is_that_of_its_spring_or_stop(push, stands, springs):
    """Its residual vanishes where the idler belongs, and what the matrix is made of is its derivative."""
    row = Row(Recoil(mass=8e3, stiffness=1e8, preload=1e6, stroke=0.01, damping=4e5))
    force = -push * row.recoil.preload
    place = stands * min((push - 1.0) * row.recoil.preload / row.recoil.stiffness, row.recoil.stroke)
    assert row.residual(place, force) == pytest.approx(0.0, abs=1e-6 * STIFFNESS * row.recoil.stroke)
    by_place = (row.residual(place + 1e-6, force) - row.residual(place - 1e-6, force)) / 2e-6
    by_rate = (row.residual(place, force, 1e-4) - row.residual(place, force, -1e-4)) / 2e-4
    by_force = (row.residual(place, force + 10.0) - row.residual(place, force - 10.0)) / 20.0
    assert by_place == pytest.approx(STIFFNESS)
    assert by_force == pytest.approx(-STIFFNESS / row.recoil.stiffness if springs else 0.0, abs=1e-9)
    assert by_rate == pytest.approx(STIFFNESS * 4e-3, rel=1e-5)
    # of the same state, whose rows a residual leaves for the matrix
    row.residual(place, force)
    joints = row.system.work.joints
    assert joints.share[row.multiplier] == pytest.approx(by_force)
    assert joints.relaxation[row.multiplier] == pytest.approx(4e-3)
    assert joints.slope[row.multiplier] == pytest.approx(by_place)


@pytest.mark.parametrize("speed", [-0.5, 0.5])
@pytest.mark.parametrize("end", [0.0, 0.01], ids=["as installed", "end of the stroke"])
def test_residual_of_a_recoil_spring_is_continuous_where_it_meets_a_stop(end, speed):
    """At any speed: a jump would leave states without a solution on either side of it."""
    row = Row(Recoil(mass=8e3, stiffness=1e8, preload=1e6, stroke=0.01))
    push = -(row.recoil.preload + row.recoil.stiffness * end)
    sides = [row.residual(-end, push + change, speed) for change in (-1.0, 1.0)]
    assert sides[0] == pytest.approx(sides[1], abs=2.1 * STIFFNESS / row.recoil.stiffness)
    # and a spring without a damper comes to rest there
    assert sides[0] == pytest.approx(STIFFNESS * SETTLING * speed, rel=1e-3)


def test_an_idler_has_one_spring():
    tensioner = Tensioner(mass=8e3, stiffness=2e8, preload=3e7)
    recoil = Recoil(mass=8e3, stiffness=2e8, preload=1e6, stroke=0.1)
    with pytest.raises(ParameterError, match="tensioner and recoil must not be given together"):
        Case.closed().with_({"gear.idler.tensioner": tensioner, "gear.idler.recoil": recoil})


def test_tension_is_still_given_as_sag_or_force_with_a_recoil_spring():
    case = sprung(1e6).with_({"gear.idler.take_up": None, "gear.idler.sag": 0.06})
    assert case.gear.is_set_by_tension
    assert case.gear.sliding_idlers == ("idler",)
