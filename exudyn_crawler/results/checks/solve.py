"""Check cases solved: loads in balance, stresses, hand formulas, peaks by region, cycles to a crack."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from exudyn_crawler.case import Track
from exudyn_crawler.case.parameters.fields import errors_at
from exudyn_crawler.model.shoe_mesh import pin_interfaces
from exudyn_crawler.results.checks import cases as ready, roller_path
from exudyn_crawler.results.life.duty import UNLOADED
from exudyn_crawler.results.stress.hot_spots import BORES, REGIONS, shoe_regions
from fem import ElasticBody, Partition, Shapes
from fem.body import interfaces, supports
from fem.body.element_stress import principal, von_mises
from fem.body.mesh import triangle_normals
from fem.fatigue import defects
from fem.stress import trust
from meshes import STEEL, ShoeDimensions, mesh_named, mesh_shoe, with_load_surfaces
from meshes.checks import check_surfaces

POINTS, RAIL_POINTS = 0.02, 0.01
"""m between points on the underside and on other faces, and on the rails."""
BED = (5, 15)
"""Grid along x and y of tractions by which the underside bends."""
LINE = 4e-3
"""m, half the length of the contact of a tread at the very end of a rail: that of Hertz's."""
BALANCE = 1e-3
"""Part of the sum of all forces (times 1 m for moments) that may be out of balance; meshes round places."""
NORMALS: dict[ready.Facing, tuple[int, float]] = {
    "front": (0, 1.0),
    "rear": (0, -1.0),
    "left": (1, 1.0),
    "right": (1, -1.0),
    "up": (2, 1.0),
    "down": (2, -1.0),
}
"""Axis and sign of the way that a face looks."""
MEGA = 1e6
SURVIVAL = 0.975
BLOW_STEPS = 8  # to the force of a blow, whose error each makes less than half
BLOW = ("blow in MN", "its compliance in m/N")  # columns of the moments
CYCLES = "cycles to a crack"
AT_BORES = "bores, not to be used"
"""Columns of cycles, and of fewer ones beside a pin's coupling."""
WIDEST = 10  # nodes of a region with the widest cycles in tension, at which a defect is looked at


class CheckedShoe:
    """Finite elements of a check's shoe: its factorized stiffness, its surface and regions.

    Loads are forces on all nodes, then forces and moments on all joint centres: arrays (3 n + 24,), N and
    N m, or of several columns. Raises as `mesh_named` and `mesh_shoe`.
    """

    def __init__(self, check: ready.ShoeCheck) -> None:
        track = check.track or Track.ph4100c()
        if check.dimensions:
            shoe_mesh = mesh_shoe(ShoeDimensions(**check.dimensions), check.mesh)
            name = check.name
            mesh = with_load_surfaces(shoe_mesh)
        else:
            name = check.mesh
            mesh = mesh_named(check.mesh)
        check_surfaces(mesh, "underside", name)
        self.mesh, self.body = mesh, ElasticBody(mesh, STEEL)
        pins = [
            replace(pin_interface, spider=check.spider) for pin_interface in pin_interfaces(mesh, name, track)
        ]
        self.partition, self.outline = Partition(self.body, pins), ready.ShoeOutline.of(mesh)
        empty = (np.empty((len(mesh.nodes), count, 0)) for count in (3, 6))
        shapes = Shapes(mesh, STEEL, tuple(pins), *empty)
        self.regions = shoe_regions(shapes, track)[mesh.surface_nodes]
        self._points: dict[str, supports.SurfacePoints] = {}

    @cached_property
    def bed(self) -> supports.OneSidedBed:
        """Points of the underside that ground may support."""
        points = supports.surface_points(self.mesh, self.mesh.surface("underside"), POINTS)
        return supports.OneSidedBed(self.partition, points, BED)

    @cached_property
    def of_centers(self) -> np.ndarray:
        """Motions (24, 6) of the joint centres when the body moves as a whole."""
        return interfaces.rigid_motion_of_centers(self.partition.interfaces, self.body.center_of_mass)

    def facing(self, way: ready.Facing) -> supports.SurfacePoints:
        """Points of all faces that look one way, those beneath others too."""
        if way not in self._points:
            axis, sign = NORMALS[way]
            normal = triangle_normals(self.mesh.nodes[self.mesh.boundary[:, :3]])
            looking = sign * normal[:, axis] >= 0.9 * np.linalg.norm(normal, axis=1)
            self._points[way] = supports.surface_points(self.mesh, self.mesh.boundary[looking], POINTS)
        return self._points[way]

    def rail(self, tread: ready.TreadForce) -> np.ndarray:
        """Nodal forces (n, 3) of a tread, N."""
        rails = self.outline.rails
        half = 0.5 * tread.length
        if rails is None:
            raise ValueError("a tread must press on a rail, the shoe has none")
        if "rail" not in self._points:
            self._points["rail"] = supports.surface_points(self.mesh, self.mesh.surface("rails"), RAIL_POINTS)
        points = self._points["rail"]
        sign = 1.0 if tread.side == "left" else -1.0
        middle = 0.5 * (rails.front + rails.rear)
        x = {None: middle + tread.x, "front": rails.front - tread.x, "rear": rails.rear + tread.x}[tread.end]
        if not rails.rear <= x <= rails.front:
            raise ValueError(f"a tread must press on the rail, got x = {x:.4g} m in the shoe")
        half = min(half, max(min(x - rails.rear, rails.front - x), LINE))
        x = min(max(x, rails.rear + half), rails.front - half)
        y = (rails.left if sign > 0 else rails.right) + sign * tread.across
        width = rails.width if tread.width is None else tread.width
        place = points.positions[:, :2]
        target = np.array([x, y])
        sides = 0.5 * np.array([max(2.0 * half, 2.0 * RAIL_POINTS), width])
        near = points.chosen(np.flatnonzero((np.abs(place - target) <= sides).all(axis=1)))
        if len(near.areas) < 3:
            raise ValueError(f"a tread must press on the rail, got y = {y:.4g} m in the shoe")
        return near.spread(np.array([0.0, 0.0, -tread.force]), _centred(near, target))

    def pressure(self, load: ready.Pressure) -> np.ndarray:
        """Nodal forces (n, 3) of a pressure, N."""
        points = self.facing(load.facing)
        along = NORMALS[load.facing][0]
        inside = _inside(points.positions, load, [axis for axis in range(3) if axis != along])
        if not inside.any():
            raise ValueError(f"no face looks {load.facing} between {load.low} and {load.high} m")
        return points.chosen(np.flatnonzero(inside)).spread(np.array(load.force))

    def loads(self, case: ready.CheckCase) -> np.ndarray:
        """Loads of a case without the ground, what pins hold included.

        A ValueError says what is not in balance.
        """
        loads = np.zeros(self.mesh.nodes.size + len(self.of_centers))
        forces, centers = self.parts(loads)
        for hold in (*map(self.rail, case.treads), *map(self.pressure, case.pressures)):
            forces += hold.ravel()
        joints = [interface.name for interface in self.partition.interfaces]
        known = {f"{name} {axis}": 6 * k + i for k, name in enumerate(joints) for i, axis in enumerate("xyz")}
        if unknown := [place for place in case.held_by if place not in known]:
            raise ValueError(f"held_by must be of {list(known)}, got {unknown}")
        for pin in case.pins:
            centers[[known[f"{pin.pin} {axis}"] for axis in "xyz"]] += pin.force
        size = np.abs(forces).sum() + np.abs(centers).sum()
        # the ground carries forces upward and moments about x and y
        rows = [0, 1, 5] if case.ground is not None else list(range(6))
        if held := [known[place] for place in case.held_by]:
            left = self.resultant(loads)[rows]
            centers[held] += np.linalg.lstsq(self.of_centers[held][:, rows].T, -left, rcond=None)[0]
        left = self.resultant(loads)
        if np.abs(left[rows]).max() > BALANCE * size or size == 0.0:
            raise ValueError(
                f"loads must be in balance but for what ground carries, got forces "
                f"{left[:3].round(1).tolist()} N and moments {left[3:].round(1).tolist()} N m left"
            )
        return loads

    def parts(self, loads: np.ndarray) -> list[np.ndarray]:
        """Views of loads: on nodes (3 n, ...) and on joint centres (24, ...)."""
        return np.split(loads, [self.mesh.nodes.size])

    def resultant(self, loads: np.ndarray) -> np.ndarray:
        """Force and moment (6,) about the centre of mass."""
        forces, centers = self.parts(loads)
        return self.body.rigid_modes.T @ forces + self.of_centers.T @ centers

    def answers(self, loads: np.ndarray) -> np.ndarray:
        """Displacements (n, 3, k), m, under loads (3 n + 24, k)."""
        return self.partition.static_response(*self.parts(loads)).reshape(-1, 3, loads.shape[1])


def _inside(places: np.ndarray, part: ready.Pressure | ready.GroundPart, across: list[int]) -> np.ndarray:
    """Which places (p, axes) lie in the box of a part, or in the disc in it over two of the axes."""
    low = np.array(part.low)
    high = np.array(part.high)
    away = np.abs(places - 0.5 * (low + high)) / (0.5 * (high - low))
    inside = (away <= 1.0).all(axis=1)
    return inside & ((away[:, across] ** 2).sum(axis=1) <= 1.0) if part.round else inside


def _centred(points: supports.SurfacePoints, place: np.ndarray) -> np.ndarray:
    """Density (p,) that changes evenly so that a force acts at a place (2,), as far as it pushes."""
    off = points.positions[:, :2] - place
    plane = np.column_stack((np.ones(len(off)), off))
    weights = np.linalg.lstsq(
        plane.T @ (points.areas[:, None] * plane), np.array([1.0, 0.0, 0.0]), rcond=None
    )[0]
    return np.maximum(plane @ weights, 0.0)


@dataclass(frozen=True)
class CheckResults:
    """Check cases of a shoe, solved.

    `stress` (cases, nodes, 6) in Pa and `displacement` (cases, nodes, 3) in m are those of the surface's
    nodes, `forces` (n, 3, cases) in N those of loads and ground on all nodes, without pins. `table` has a row
    for each case and region, `moments` one for each case, `cycles` one for each cycle and region, `hertz` one
    for each force, width and tilt of a tread.
    """

    check: ready.ShoeCheck
    shoe: CheckedShoe
    cases: tuple[ready.CheckCase, ...]
    stress: np.ndarray
    displacement: np.ndarray
    forces: np.ndarray
    table: pd.DataFrame
    moments: pd.DataFrame
    cycles: pd.DataFrame
    hertz: pd.DataFrame

    @property
    def worst_cycles(self) -> pd.DataFrame:
        """Rows of `cycles` with the region that cracks first, of every pair; the shortest first.

        Bores, whose stress beside a pin's coupling is not to be used, are no such region. Where they had
        fewer cycles, a last column `AT_BORES` says how many; where nothing else changes, they stand alone.
        """
        pair = ["from", "to"]
        is_bore = self.cycles["region"] == BORES
        usable = self.cycles[~is_bore]
        worst = usable.loc[usable.groupby(pair, sort=False)[CYCLES].idxmin()]
        bores = self.cycles[is_bore]
        found = worst.merge(bores[[*pair, CYCLES]].rename(columns={CYCLES: AT_BORES}), how="left", on=pair)
        found[AT_BORES] = found[AT_BORES].where(found[AT_BORES] < found[CYCLES])
        alone = bores.merge(worst[pair], how="left", on=pair, indicator="there").query("there == 'left_only'")
        table = pd.concat((found, alone.drop(columns="there")), ignore_index=True).sort_values(CYCLES)
        return table if table[AT_BORES].notna().any() else table.drop(columns=AT_BORES)

    def cycle(self, first: str, second: str) -> pd.DataFrame:
        """Cycles to a crack in every region between two cases, or `UNLOADED` and one."""
        stress = dict(zip([case.name for case in self.cases], self.stress, strict=True))
        return cycle_table(self.check, self.shoe, stress, [(first, second)])


def all_cases(check: ready.ShoeCheck, outline: ready.ShoeOutline) -> tuple[ready.CheckCase, ...]:
    """Ready cases at every level of the force, by "case, level", and the check's own."""
    cases = [
        ready_case.with_(name=f"{ready_case.name}, {level.name}")
        for level in check.levels
        for ready_case in ready.ready_cases(outline, level.force, check.machine)
    ]
    return (*cases, *check.cases)


def solve_cases(
    check: ready.ShoeCheck, shoe: CheckedShoe, say: Callable[[str], None] = lambda _text: None
) -> CheckResults:
    """Solve all cases of a check; a ValueError names one not in balance or that ground cannot carry."""
    cases = all_cases(check, shoe.outline)
    if check.track is not None:
        cases = _possible(check, shoe, cases, say)
    loads, answers, blows = _solved(shoe, cases, say)
    say("stresses, peaks and cycles")
    surface = shoe.mesh.surface_nodes
    stress = np.ascontiguousarray(np.moveaxis(shoe.body.stress(answers, surface), 2, 0))
    names = [case.name for case in cases]
    by_name = dict(zip(names, stress, strict=True))
    pairs = [(UNLOADED, name) for name in names]
    pairs += [
        (f"{a}, {level.name}", f"{b}, {level.name}")
        for level in check.levels
        for a, b in ready.ready_cycles(shoe.outline)
        if {f"{a}, {level.name}", f"{b}, {level.name}"} <= {*names}
    ]
    return CheckResults(
        check,
        shoe,
        cases,
        stress,
        np.moveaxis(answers[surface], 2, 0),
        shoe.parts(loads)[0].reshape(answers.shape),
        _peaks(check, shoe, names, stress, answers),
        _moments(shoe, cases, loads, blows),
        cycle_table(check, shoe, by_name, pairs),
        roller_path.hertz_table(check, cases),
    )


def _possible(
    check: ready.ShoeCheck, shoe: CheckedShoe, cases: Sequence[ready.CheckCase], say: Callable[[str], None]
) -> tuple[ready.CheckCase, ...]:
    """Cases without ready ones that a shoe cannot have: what they press on is not there, or it tips over."""
    chosen = {case.name for case in check.cases}
    possible = []
    left_out: dict[tuple[str, str], list[str]] = {}
    unbent = np.zeros_like(shoe.mesh.nodes)
    for case in cases:
        try:
            loads = shoe.loads(case)
            if case.ground is not None:
                _rest(shoe, case, loads, unbent)
        except ValueError as error:
            if case.name in chosen:
                raise
            name, _, level = case.name.rpartition(", ")
            left_out.setdefault((name, str(error)), []).append(level)
        else:
            possible.append(case)
    for (name, reason), levels in left_out.items():
        at_levels = "" if len(levels) == len(check.levels) else f" ({', '.join(levels)})"
        say(f"left out: {name}{at_levels}: {reason}")
    return tuple(possible)


def case_shapes(
    check: ready.ShoeCheck, names: Sequence[str], say: Callable[[str], None] = lambda _text: None
) -> Shapes:
    """Displacement and stress of a shoe under some of its check cases, a column each.

    A ValueError names a case that there is not, and what there is; or is as in `solve_cases`.
    """
    shoe = CheckedShoe(check)
    known = {case.name: case for case in all_cases(check, shoe.outline)}
    if wrong := sorted(set(names) - set(known)):
        raise ValueError(f"{check.name}: no check case {wrong}; there are {[*known]}")
    _, answers, _ = _solved(shoe, [known[name] for name in names], say)
    joints = tuple(shoe.partition.interfaces)
    return Shapes(shoe.mesh, STEEL, joints, answers, shoe.body.stress(answers))


def _solved(
    shoe: CheckedShoe, cases: Sequence[ready.CheckCase], say: Callable[[str], None]
) -> tuple[np.ndarray, np.ndarray, dict[str, tuple[float, float]]]:
    """Loads (3 n + 24, k) with the ground's, answers (n, 3, k), and blows as in `_blow` by their cases."""
    each = []
    blows = {}
    for case in cases:
        with errors_at(f"case {case.name!r}"):
            load_case = case
            if case.energy is not None:
                load_case, blows[case.name] = _blow(shoe, case, case.energy)
            each.append(shoe.loads(load_case))
    say(f"{len(cases)} cases in balance: answers of {len(shoe.mesh.nodes)} nodes")
    loads = np.stack(each, axis=-1)
    answers = shoe.answers(loads)
    below = np.zeros_like(loads)
    carried = [k for k, case in enumerate(cases) if case.ground is not None]
    for k in carried:
        with errors_at(f"case {cases[k].name!r}"):
            pushed = _rest(shoe, cases[k], each[k], answers[..., k]).forces
        shoe.parts(below)[0][2::3, k] = shoe.bed.points.shapes.T @ pushed
    say("answers to what the ground pushes with")
    if carried:
        answers[..., carried] += shoe.answers(below[:, carried])
    return loads + below, answers, blows


def _rest(shoe: CheckedShoe, case: ready.CheckCase, loads: np.ndarray, answer: np.ndarray) -> supports.Rest:
    """Rest of the shoe on the ground of a case."""
    assert case.ground is not None
    points = shoe.bed.points
    x = points.positions[:, :2]
    gap = np.zeros(len(x))
    stiffness = np.full(len(x), case.ground.stiffness)
    for part in case.ground.parts:
        inside = _inside(x, part, [0, 1])
        gap[inside] = -part.height
        stiffness[inside] = part.stiffness
    shift = points.shapes @ answer[:, 2]
    return shoe.bed.settle(shoe.resultant(loads), shift, gap, stiffness)


def _blow(
    shoe: CheckedShoe, case: ready.CheckCase, energy: float
) -> tuple[ready.CheckCase, tuple[float, float]]:
    """Case with the pressures whose work until they rest, half of force times way, is an energy in J.

    All of it goes into shoe and ground, from the rest under all else: rope, crowd and dipper give nothing.
    Their force (MN), and the compliance (m/N) of shoe and ground.
    """
    alone = shoe.loads(case.with_(pressures=(), energy=None))
    blow = shoe.loads(case.with_(energy=None)) - alone
    answers = shoe.answers(np.stack((alone, blow), axis=-1))
    forces = shoe.parts(blow)[0].reshape(-1, 3)
    own_way = float(np.sum(forces * answers[..., 1]))
    whole = float(np.linalg.norm(forces.sum(axis=0)))
    below = shoe.bed.points.shapes @ answers[:, 2, 1]
    resultant = shoe.resultant(blow)[supports.UPRIGHT]

    def way(times: float) -> float:
        """Way of the unit blow's forces beside its own, m N; what ground does there by reciprocity."""
        rest = _rest(shoe, case, alone + times * blow, answers @ (1.0, times))
        return float(rest.forces @ below + resultant @ rest.motion)

    at_rest = way(0.0)
    times = 1.0
    for _ in range(BLOW_STEPS):
        work = own_way + (way(times) - at_rest) / times  # of the unit blow by its own way, J
        times = np.sqrt(2.0 * energy / work)
    scaled = tuple(
        pressure.with_(force=tuple(times * part for part in pressure.force)) for pressure in case.pressures
    )
    return case.with_(pressures=scaled, energy=None), (times * whole / MEGA, work / whole**2)


def _moments(
    shoe: CheckedShoe,
    cases: Sequence[ready.CheckCase],
    loads: np.ndarray,
    blows: Mapping[str, tuple[float, float]],
) -> pd.DataFrame:
    """Bending moment at y = 0 by all that acts left of it, by hand, and the stress of a beam; blows."""
    cut = supports.section(shoe.mesh, 0.0)
    rows = []
    places = np.concatenate((shoe.mesh.nodes, [interface.center for interface in shoe.partition.interfaces]))
    left = places[:, 1] > 0.0
    _, y, z = places[left].T
    for case, load in zip(cases, loads.T, strict=True):
        forces, centers = shoe.parts(load)
        acting = np.concatenate((forces.reshape(-1, 3), centers.reshape(-1, 6)[:, :3]))[left]
        moment = float((y * acting[:, 2] - (z - cut.middle) * acting[:, 1]).sum())
        by_hand = np.nan if case.hand_moment is None else case.hand_moment
        row = {
            "case": case.name,
            "moment at y = 0 in kN m": moment / 1e3,
            "by hand in kN m": by_hand / 1e3,
            "over it": moment / by_hand,
            "beam, underside in MPa": moment * (cut.middle - cut.bottom) / cut.second / MEGA,
            "beam, top in MPa": moment * (cut.middle - cut.top) / cut.second / MEGA,
        }
        rows.append(row | dict(zip(BLOW, blows.get(case.name, (np.nan, np.nan)), strict=True)))
    return pd.DataFrame(rows)


def _peaks(
    check: ready.ShoeCheck, shoe: CheckedShoe, names: Sequence[str], stress: np.ndarray, answers: np.ndarray
) -> pd.DataFrame:
    """Highest von Mises stress of each case and region, with what the mesh leaves open."""
    tables = []
    for k, name in enumerate(names):
        mises = von_mises(stress[k])
        resolved = trust.resolution(shoe.mesh, STEEL, answers[..., k])
        highest = pd.Series(mises).groupby(shoe.regions).idxmax()
        rows = highest.reindex([region for region in REGIONS if region in highest]).to_numpy()
        node = shoe.mesh.surface_nodes[rows]
        region = shoe.regions[rows]
        error = resolved.error[node]
        principals = principal(stress[k, rows]) / MEGA
        verdicts = trust.verdict_numbers(error, error, resolved.relative_jump[node], region == BORES)
        columns = {
            "case": name,
            "region": region,
            "von Mises in MPa": mises[rows] / MEGA,
            "greatest principal in MPa": principals[:, 2],
            "least principal in MPa": principals[:, 0],
            "mesh error": error,
            "verdict": trust.verdict_words(verdicts),
            "above yield": np.where(mises[rows] > check.material.yield_strength, "yes", ""),
            "node": node,
        }
        places = zip(("x in m", "y in m", "z in m"), shoe.mesh.nodes[node].T, strict=True)
        tables.append(pd.DataFrame(columns | dict(places)))
    return pd.concat(tables, ignore_index=True)


def cycle_table(
    check: ready.ShoeCheck,
    shoe: CheckedShoe,
    stress: Mapping[str, np.ndarray],
    pairs: Sequence[tuple[str, str]],
) -> pd.DataFrame:
    """Cycles to a crack between states, by region: the least that 97.5 % survive, of any node.

    The amplitude is half the von Mises stress of the difference of both states, the mean stress that of
    their mean with the sign of its hydrostatic part.
    """
    none = np.zeros((len(shoe.regions), 6))
    rows = []
    material = check.material
    curves = {region: material.curve("elementary", region) for region in REGIONS}
    for first, second in pairs:
        if wrong := {first, second} - {*stress, UNLOADED}:
            raise ValueError(f"cycles: no case {sorted(wrong)}; there are {[*stress]}")
        a, b = (stress.get(name, none) for name in (first, second))
        change = a - b
        mean = 0.5 * (a + b)
        amplitude = 0.5 * von_mises(change)
        signed = np.where(mean[:, :3].sum(axis=1) < 0.0, -1.0, 1.0) * von_mises(mean)
        highest = np.maximum(von_mises(a), von_mises(b))
        for region in REGIONS:
            places = np.flatnonzero((shoe.regions == region) & (amplitude > 1.0))
            if not len(places):
                continue
            damage = curves[region].damage(amplitude[places], signed[places], (SURVIVAL,))[0]
            place = places[np.argmax(damage)]
            often = 1.0 / float(damage.max())
            row = {
                "from": first,
                "to": second,
                "region": region,
                "amplitude in MPa": amplitude[place] / MEGA,
                "mean in MPa": signed[place] / MEGA,
                CYCLES: often,
                "an hour": often / check.hours,
                "node": int(shoe.mesh.surface_nodes[place]),
                "above yield": "yes" if highest[place] > material.yield_strength else "",
            }
            if material.castings:
                tension = signed[places] + amplitude[places] + curves[region].residual_stress > 0.0
                widest = [place, *places[np.argsort(tension * amplitude[places])[-WIDEST:]]]
                ends = np.stack((signed - amplitude, signed + amplitude))[:, widest, None]
                each = ([defects.CycleStage(low, high, np.ones(1))] for low, high in ends.swapaxes(0, 1))
                lives = (material.defect_life(region, "elementary", stages, SURVIVAL) for stages in each)
                row["cycles to a crack, defect"] = min(lives)
            rows.append(row)
    return pd.DataFrame(rows)
