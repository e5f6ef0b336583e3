"""Contact of a track with ground of cells, as a history stores it: one contact for each shoe."""

from typing import cast

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain
from exudyn_crawler.ground import pairs
from exudyn_crawler.ground.cells.ground import CellGround
from exudyn_crawler.ground.cells.law import CellLaw
from exudyn_crawler.ground.cells.layouts import BLOCK, POINT, TRIAL, arm_of, frame_at, triple_of
from exudyn_crawler.ground.cells.pressing import ShoePoints
from exudyn_crawler.ground.compiled import kernel
from exudyn_crawler.ground.frames import along, cross, dot, norm, scaled, velocity_at
from exudyn_crawler.ground.packed import FloatArray
from exudyn_crawler.ground.terrain import TerrainCoordinates, TerrainModes

ACROSS = 15
"""Number of points across the track at which the ground is sampled before shoes are put down."""
NO_UNIT = -1
"""Flag instead of a unit's number."""
NOTHING = (0.0, 0.0, 0.0)


class CellGroundContact:
    """Shoes on cells; a `ground.contact.GroundContact` without units.

    Its `ground` is fresh or has the ruts of an earlier run.
    """

    def __init__(self, case: Case) -> None:
        terrain = case.part(CellTerrain)
        shoe = case.shoe
        none = np.zeros((0, 0))
        coms = case.gear.shoe_reference(case)
        x0, x1, y0, y1, z = shoe.footprint
        corners = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
        self.coordinates: TerrainCoordinates = TerrainModes(none, none, none, none, np.zeros(0), 1)
        self.shoe_reference = coms
        law = cast(CellLaw, case.part(CellContact).law)
        bending = [] if case.flexible is None else [number - 1 for number in case.flexible.shoes]
        parts = shoe.ground_share, shoe.ground_breadth
        self.ground = CellGround(law, terrain.relief, terrain.cell, corners, len(coms), bending, *parts)
        if (earlier := terrain.earlier(law)) and not law.kernel.forgets:
            self.ground.press_in(earlier)
        self._case, self._middle = case, float(coms[0, 1])

    @property
    def size(self) -> int:
        """Number of generalized coordinates without modes: six for each shoe."""
        return self.shoe_reference.size

    def results(
        self, q: np.ndarray, _q_t: np.ndarray, stored: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the stored contacts of states: one for each shoe, with no area if it hangs in the air.

        See `ground.contact.GroundContact`.
        """
        if stored is None:
            return np.zeros((0, pairs.RESULTS)), np.zeros(len(q), dtype=int)
        rows = stored[..., : pairs.RESULTS]
        return rows.reshape(-1, pairs.RESULTS), np.full(len(rows), rows.shape[1])

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Return the height (m) at x (m) of the straight line on which a chain is put on the ground."""
        shoe = self._case.shoe
        places = self.shoe_reference[:, 0]
        x0, x1 = places.min(), places.max()
        along = np.arange(x0 - shoe.length, x1 + shoe.length, self.ground.tiles.cell)
        across = self._middle + np.linspace(-0.5, 0.5, ACROSS) * shoe.width
        heights = self._case.part(CellTerrain).surface(*np.meshgrid(along, across)).max(axis=0)
        # a measured map may end beyond the chain's ends
        known = np.isfinite(heights)
        along = along[known]
        heights = heights[known]
        slope = np.polyfit(along, heights, 1)[0]
        return np.asarray(slope * x + (heights - slope * along).max())


@kernel
def write_contacts(shoes: ShoePoints, frames: FloatArray, out: FloatArray) -> None:
    """Write a contact of every shoe (shoes, RESULTS or more) after it was pressed on the cells.

    The penetration is the mean sinkage of the loaded area. Its rate and the slip velocity are those of the
    shoe at the centre of pressure. The normal force is that of all normal tractions. The friction torque is
    the moment about the centre of pressure that these forces do not have.
    """
    for s in range(frames.shape[0]):
        frame = frame_at(frames[s])
        area = sunk = 0.0
        pushed = NOTHING
        moment = NOTHING
        for a in range(shoes.counts[s]):
            block = a // BLOCK
            k = a % BLOCK
            traction = shoes.trial[s, a, TRIAL.traction]
            if traction <= 0.0:
                continue
            points = shoes.points[s, block]
            A = shoes.areas[s, a]
            arm = arm_of(points, shoes.bent[shoes.bending[s], block], k, frame.R)
            n = triple_of(points, POINT.normal, k)
            area = area + A
            sunk = sunk + A * (points[POINT.ground, k] - dot(n, along(frame.r, 1.0, arm)))
            force = scaled(A * traction, n)
            pushed = along(pushed, 1.0, force)
            moment = along(moment, 1.0, cross(arm, force))
        size = norm(pushed)
        out[s, :].fill(0.0)
        out[s, pairs.COLUMN.shoe] = s
        out[s, pairs.COLUMN.unit] = NO_UNIT
        if size == 0.0:
            continue
        wrench = shoes.wrench[s]
        up = (frame.R[0][2], frame.R[1][2], frame.R[2][2])
        total = (wrench[0], wrench[1], wrench[2])
        normal = scaled(1.0 / size, pushed)
        # intersection of the normal forces' line of action with the underside
        arm = scaled(1.0 / size**2, cross(pushed, moment))
        arm = along(arm, (shoes.corners[0, 2] - dot(up, arm)) / dot(up, normal), normal)
        place = along(frame.r, 1.0, arm)
        velocity = velocity_at(frame, place)
        rate = -dot(velocity, normal)
        torque = along((wrench[3], wrench[4], wrench[5]), -1.0, cross(arm, total))
        contact = pairs.Contact(
            sunk / area,
            rate,
            area,
            place,
            pushed,
            along(total, -1.0, pushed),
            along(velocity, rate, normal),
            torque,
        )
        pairs.keep(contact, s, NO_UNIT, 0, pairs.NO_PATCH, out[s])
