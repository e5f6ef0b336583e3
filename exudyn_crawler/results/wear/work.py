"""Work of wear of all pairs of an undercarriage, by place, from the history of a closed track or a machine.

========  =====================================================================================
pair      work
========  =====================================================================================
pin       tension x radius x turned angle, of sweeps of at least a threshold (`sweeps`)
bush      force of the teeth x sliding of the touching point of a bush fixed to its shoe
rail      force of all wheels on a shoe x distance rolled
wheel     force of all shoes on a wheel x distance rolled; on an idler the sum of the shoes' forces
grouser   normal force x slip; and work of friction, which is less where the shoe hardly moves
========  =====================================================================================

Wheels roll without sliding in the model, so that theirs is load times way, not sliding.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.spatial import KDTree

from exudyn_crawler.case import SIDES, Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.files import blocks
from exudyn_crawler.results.balance import BESIDE
from exudyn_crawler.results.history import catalogue
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.history.side_frame import pins_in_frame, points_in_frame
from exudyn_crawler.results.wear import closed_form, sweeps

PAIRS = ("pin", "bush", "rail", "grouser, load times slip", "grouser, friction work")
"""Pairs with a work for each link or shoe."""
REGIONS = ("lower run", "tumbler", "upper run", "idler")
NEAR = 0.2
"""Distance of a shoe from the idler's rim up to which its load counts as the idler's, pitches."""
THRESHOLDS = (0.0, 5.0, 10.0, 20.0)
"""Thresholds (deg) whose work is shown beside that of the chosen one."""


@dataclass(frozen=True)
class RunWork:
    """Work of wear over an interval of a run."""

    case: Case
    duration: float
    """s."""
    travel: np.ndarray
    """Distance travelled by each chain, forward or backward, (tracks,), m."""
    places: np.ndarray
    """x and z in the frame of the places round the loop: pins at the begin of the run, (places, 2), m."""
    by_place: xr.DataArray
    """Work over the interval, all shoes of a track together: dimensions pair, track, place, J."""
    wheels: xr.DataArray
    """Force times way of the wheels over the interval, (wheel,), J."""
    pins_by_threshold: dict[float, float]
    """Mean work of a pin over the interval by the threshold of sweeps, deg, J."""
    by_tensions: float
    """Mean work of a pin over the interval by the closed form with mean tensions of the run, J; NaN if the
    chains stand."""
    take_up: float
    """Take-up at the begin of the run, m."""

    @property
    def shoes(self) -> int:
        """Number of shoes of a track."""
        return len(self.places)

    @property
    def laps(self) -> np.ndarray:
        """Laps of each chain, (tracks,)."""
        closed = self.case.part(Closed)
        laps: np.ndarray = self.travel / (self.shoes * closed.chain_pitch(self.case.track))
        return laps

    @property
    def regions(self) -> np.ndarray:
        """Region of each place: index in `REGIONS`, (places,)."""
        return regions(self.case, self.places)

    def each(self, pair: str) -> np.ndarray:
        """Return the mean work over the interval of one link or shoe of each track, (tracks,), J."""
        work: np.ndarray = self.by_place.sel(pair=pair).sum("place").values / self.shoes
        return work


def regions(case: Case, places: np.ndarray) -> np.ndarray:
    """Return the region of places in the frame (places, 2), m: indices in `REGIONS`."""
    closed = case.part(Closed)
    (rear, low), (front, high) = closed.tumbler.place, closed.idler.place
    near = BESIDE * case.track.pitch
    run = np.where(places[:, 1] > 0.5 * (low + high), REGIONS.index("upper run"), REGIONS.index("lower run"))
    on_tumbler = places[:, 0] < rear + near
    run = np.where(on_tumbler, REGIONS.index("tumbler"), run)
    return np.where(places[:, 0] > front - near, REGIONS.index("idler"), run)


def run_work(
    history: History, radius: float, threshold: float, begin: float = 0.0, end: float | None = None
) -> RunWork:
    """Return the work of wear over an interval of a run, from `begin` to `end` (s; default: the run's end).

    `radius` of the pins is in m, `threshold` of sweeps in degrees.

    Raises
    ------
    ValueError
        If the case has no closed track, or the interval has less than three stored times.
    """
    case = history.case
    if "closed" not in case.gear.quantities:
        raise ValueError(f"wear needs a run of a closed track or a machine, got gear.kind {case.gear.kind!r}")
    time = history.time.values
    until = float(time[-1]) if end is None else end
    rows = np.flatnonzero((time >= begin * (1.0 - 1e-9)) & (time <= until * (1.0 + 1e-9)))
    if len(rows) < 3 or until > time[-1] * (1.0 + 1e-9):
        raise ValueError(
            f"a run must reach its end with at least 3 stored times, got {len(rows)} from {begin:g} to "
            f"{until:g} s of {time[-1]:g} s"
        )
    dataset = history.dataset.isel(time=slice(int(rows[0]), int(rows[-1]) + 1))
    return _work(case, dataset, radius, threshold)


def _work(case: Case, dataset: xr.Dataset, radius: float, threshold: float) -> RunWork:
    """Return the work over all of a dataset."""
    closed = case.part(Closed)
    time = dataset.time.values
    weight = np.gradient(time)
    weight[[0, -1]] *= 0.5
    states = [_Block(case, part) for part in blocks(dataset)]
    shoes = case.track.shoe_count // case.gear.tracks
    track = np.repeat(np.arange(case.gear.tracks), shoes)
    places = states[0].pins[0, :shoes]
    at_pin = KDTree(places)
    at_shoe = KDTree(0.5 * (places + np.roll(places, 1, axis=0)))
    sums = np.zeros((len(PAIRS), case.gear.tracks, shoes))
    wheels = np.zeros(dataset.sizes["wheel"])
    row = 0
    for state in states:
        dt = weight[row : row + len(state.speed)]
        row += len(dt)
        place = at_shoe.query(state.middles)[1]
        for pair, power in state.powers():
            np.add.at(
                sums[PAIRS.index(pair)], (np.broadcast_to(track, place.shape), place), power * dt[:, None]
            )
        wheels += dt @ state.wheel_power
    angle = np.concatenate([state.hinge for state in states])
    force = np.concatenate([state.tension for state in states])
    pins = np.concatenate([state.pins for state in states])
    work = sweeps.sweep_work(angle, force, radius, np.radians(threshold))
    place = at_pin.query(pins[1:])[1]
    np.add.at(sums[PAIRS.index("pin")], (np.broadcast_to(track, place.shape), place), work)
    by_threshold = {
        degrees: float(sweeps.sweep_work(angle, force, radius, np.radians(degrees)).sum(0).mean())
        for degrees in sorted({*THRESHOLDS, threshold})
    }
    speed = np.concatenate([state.speed for state in states])
    travel = np.sum(np.abs(speed) * weight[:, None], axis=0)
    pitch = closed.chain_pitch(case.track)
    laps = float(travel.mean()) / (shoes * pitch)
    upper = pins[..., 1] > 0.5 * (closed.tumbler.place[1] + closed.idler.place[1])
    take_up = float(np.atleast_1d(dataset.take_up.isel(time=0).values).max())
    ends = closed.tumbler.place[0], closed.idler.place[0] + take_up
    means = closed_form.mean_tensions(force, pins[..., 0], upper, ends, pitch)
    by_tensions = laps * closed_form.pin_work(radius, closed_form.bends_of(case), means)
    sides = list(SIDES[: case.gear.tracks]) if case.gear.tracks > 1 else [""]
    coordinates = {"pair": list(PAIRS), "track": sides}
    return RunWork(
        case,
        float(time[-1] - time[0]),
        travel,
        places,
        xr.DataArray(sums, coordinates, ["pair", "track", "place"]),
        xr.DataArray(wheels, {"wheel": dataset.wheel.values}, ["wheel"]),
        by_threshold,
        by_tensions if laps else np.nan,
        take_up,
    )


class _Block:
    """Part of a history as arrays with the dimensions time, item, axis; lengths in m, forces in N."""

    def __init__(self, case: Case, data: xr.Dataset) -> None:
        self.case = case
        self.data = data
        closed = case.part(Closed)
        self.track = np.repeat(np.arange(case.gear.tracks), case.track.shoe_count // case.gear.tracks)
        self.turn = catalogue.rotation_matrices(self._of("angles", "shoe"))
        self.frame = catalogue.rotation_matrices(data.side_frame_angles.transpose("time", "axis").values)
        self.position = self._of("position", "shoe")
        self.tumbler = data.tumbler_speed.values.reshape(len(data.time), -1)
        self.speed = self.tumbler * closed.travel_per_angle(case.track)
        self.tension = catalogue.link_tension(case, data, data).values
        # x and z in the axes of the frame
        self.pins = pins_in_frame(case, data)[..., ::2]
        half = 0.5 * closed.chain_pitch(case.track)
        middle = (case.track.pin_ahead - half, 0.0, case.track.pin_height)
        self.middles = points_in_frame(data, middle)[..., ::2]

    def _of(self, name: str, item: str) -> np.ndarray:
        """Return a quantity as (time, item, axis)."""
        values: np.ndarray = self.data[name].transpose("time", item, "axis").values.astype(float)
        return values

    @property
    def hinge(self) -> np.ndarray:
        """Angle of every hinge in the chain's plane, shoe ahead less shoe behind, (times, joints), rad."""
        pitch = self._of("angles", "shoe")[..., 1].reshape(len(self.tumbler), self.case.gear.tracks, -1)
        angle = np.roll(pitch, -1, axis=2) - pitch
        angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
        flat: np.ndarray = angle.reshape(len(angle), -1)
        return flat

    @property
    def wheel_power(self) -> np.ndarray:
        """Force on the wheels times the speed of their chain, (times, wheels), W.

        Shoes press on an idler in different directions: their forces add up as numbers, not as vectors.
        """
        closed = self.case.part(Closed)
        rails = self.case.shoe.roller_path
        force = np.linalg.norm(self._of("wheel_force", "wheel"), axis=2)
        track = np.repeat(np.arange(self.case.gear.tracks), force.shape[1] // self.case.gear.tracks)
        load = np.linalg.norm(self._of("wheel_load", "shoe"), axis=2)
        take_up = self.data.take_up.values.reshape(len(force), -1)
        (x, z), radius = closed.idler.place, closed.idler.radius
        reach = radius + rails.height - self.case.track.pin_height + NEAR * self.case.track.pitch
        ahead = self.middles[..., 0] - (x + take_up[:, self.track])
        on_idler = np.where(np.hypot(ahead, self.middles[..., 1] - z) < reach, load, 0.0)
        names = self.data.wheel.values.astype(str)
        for number, wheel in enumerate(np.flatnonzero([name.endswith("idler") for name in names])):
            force[:, wheel] = on_idler[:, self.track == number].sum(axis=1)
        power: np.ndarray = force * np.abs(self.speed[:, track])
        return power

    def powers(self) -> Iterator[tuple[str, np.ndarray]]:
        """Yield the pairs of the shoes with their power of wear, (times, shoes), W."""
        yield "bush", self._bush()
        load = np.linalg.norm(self._of("wheel_load", "shoe"), axis=2)
        yield "rail", load * np.abs(self.speed[:, self.track])
        slip = self._of("slip_velocity", "contact")
        normal = np.linalg.norm(self._of("normal_force", "contact"), axis=2)
        yield "grouser, load times slip", self._by_shoe(normal * np.linalg.norm(slip, axis=2))
        rubbed = -np.sum(self._of("friction_force", "contact") * slip, axis=2)
        turned = np.sum(self._by_shoe(self._of("friction_torque", "contact")) * self._omega, axis=2)
        yield "grouser, friction work", self._by_shoe(rubbed) - turned

    @property
    def _omega(self) -> np.ndarray:
        return self._of("angular_velocity", "shoe")

    def _by_shoe(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over the contacts of each shoe: (times, shoes, ...) of (times, contacts, ...)."""
        summed = np.zeros((len(values), len(self.track), *values.shape[2:]))
        np.add.at(summed.swapaxes(0, 1), self.data.contact_shoe.values - 1, values.swapaxes(0, 1))
        return summed

    def _bush(self) -> np.ndarray:
        """Return tooth force times sliding of the touching point of the bushes, (times, shoes), W."""
        closed = self.case.part(Closed)
        lugs = np.array([place for _, place in closed.lugs(self.case.track)])
        arm = self.turn @ (lugs.mean(axis=0) * [1.0, 0.0, 1.0])
        velocity = self._of("velocity", "shoe") + np.cross(self._omega, arm)
        data = self.data
        frame_spin = data.side_frame_angular_velocity.transpose("time", "axis").values
        origin = data.side_frame_position.transpose("time", "axis").values
        centre = data.tumbler_position.values.reshape(len(data.time), -1, 3)
        if "track" in data.tumbler_position.dims:
            centre = data.tumbler_position.transpose("time", "track", "axis").values
        spin = frame_spin[:, None] + self.frame[:, None, :, 1] * self.tumbler[..., None]
        of_centre = data.side_frame_velocity.transpose("time", "axis").values[:, None]
        of_centre = of_centre + np.cross(frame_spin[:, None], centre - origin[:, None])
        force = self._of("tooth_force", "shoe")
        size = np.linalg.norm(force, axis=2)
        normal = force / np.maximum(size, 1e-9)[..., None]
        # the bush touches the tooth on the side from which the force comes
        touch = -closed.tumbler.lug_radius * normal
        of_bush = velocity + np.cross(self._omega, touch)
        from_centre = self.position + arm + touch - centre[:, self.track]
        of_tooth = of_centre[:, self.track] + np.cross(spin[:, self.track], from_centre)
        sliding = of_bush - of_tooth
        along = sliding - np.sum(sliding * normal, axis=2)[..., None] * normal
        power: np.ndarray = size * np.linalg.norm(along, axis=2)
        return power
