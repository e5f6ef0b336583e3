"""Contact of a pin that fits its bore: pressures of unit forces by direction, without tension or friction.

A pin that fits presses on one side of its bore. The arc of this receding contact does not depend on the
force (J. Dundurs and M. Stippes, J. Appl. Mech. 37 (1970) 965-970), so that pressures and stresses are the
force times a field by its direction. Pressures are constant on each face of the bore. An active set finds the
pressed faces: these have no gap, the others no pressure.

The pin is an elastic cylinder with the radius of the bore. Its sections flatten as disks in plane strain
(J. H. Michell's solutions). It bends as a beam with shear. The neighbours load it where it leaves the bore:
at both ends of a lug, or between the cheeks of a fork.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.sparse import csr_array, hstack

from fem.body.bores import BoreFaces, bore_faces
from fem.body.elasticity import Material
from fem.body.interfaces import Interface
from fem.body.mesh import Floats
from fem.body.reduction import Partition

DIRECTIONS = 36
"""Number of directions of a force."""
KERN = 1.0 / 6.0
"""Greatest eccentricity of a force that presses along the whole bore, fraction of its length."""
SLICE = 0.4
"""Length of a slice of the pin, fraction of its radius."""
SHEAR = 0.886
"""Shear coefficient of a round beam (G. R. Cowper, J. Appl. Mech. 33 (1966) 335-340)."""
STATIONS = 401  # number of positions along the pin for the integrals of its bending
ROUNDS = 20
"""Greatest number of rounds of the active set; most directions take 3 to 5."""
FIRM = 1e4
"""Weight of the resultant where pressures are found by least squares, over that of the energy."""
AT_ONCE = 32  # number of faces whose responses are solved for at once
NEARLY = 1e-3
"""Tension after least squares that counts as zero, fraction of the greatest pressure."""
ROUNDING = 1e-9
"""Pressure below zero, and gap, that count as zero, fraction of the greatest one."""


def pin_flexibility(bore: BoreFaces, pin: Material) -> Floats:
    """Return the work (f, f) of pressures on the faces on the motion of an elastic pin's surface, m3/Pa."""
    count = max(round(bore.length / (SLICE * bore.radius)), 1)
    width = bore.length / count
    low = bore.ends[0]
    number = np.clip(((bore.along - low) / width).astype(int), 0, count - 1)
    middles = low + width * (np.arange(count) + 0.5)

    def by_slice(weights: Floats) -> Floats:
        """Return the sums (f, slices) of weights (f, q)."""
        sums = np.zeros((len(weights), count))
        np.add.at(sums, (np.arange(len(weights))[:, None], number), weights)
        return sums

    nu = pin.poissons_ratio
    shear = pin.lame[1]
    size = 1.0 / (np.pi * bore.radius * width)
    even = by_slice(bore.areas)
    work = size * bore.radius * (1.0 - 2.0 * nu) / (4.0 * shear) * even @ even.T
    for n in range(2, max(int(bore.around) // 4, 2) + 1):
        compliance = bore.radius * (2.0 * (1.0 - nu) * n - (1.0 - 2.0 * nu)) / (2.0 * shear * (n**2 - 1.0))
        for wave in (np.cos(n * bore.angles), np.sin(n * bore.angles)):
            part = by_slice(bore.areas * wave)
            work += size * compliance * part @ part.T
    bent = _bending(bore, middles, pin)
    for wave in (np.cos(bore.angles), np.sin(bore.angles)):
        part = by_slice(bore.areas * wave)
        work += part @ bent @ part.T
    return np.asarray(work)


def _bending(bore: BoreFaces, places: Floats, pin: Material) -> Floats:
    """Return the deflection (k, k) of a pin at places along it by unit forces there, m/N.

    It rests on two supports, where it leaves the bore.
    """
    ends = bore.ends
    taken = np.sort(bore.along.ravel())
    gaps = np.diff(taken)
    widest = int(gaps.argmax())
    if gaps[widest] > 0.2 * bore.length:
        ends = taken[[widest, widest + 1]]
    y = np.linspace(bore.ends[0], bore.ends[1], STATIONS)
    step = y[1] - y[0]
    share = (places - ends[0]) / (ends[1] - ends[0])
    reactions = np.stack((share - 1.0, -share), axis=1)
    forces = [(places[:, None], 1.0), *((ends[k], reactions[:, k, None]) for k in (0, 1))]
    moment = sum(force * np.maximum(y - at, 0.0) for at, force in forces)
    cut = sum(force * (y > at) for at, force in forces)
    radius = bore.radius
    bending = pin.youngs_modulus * np.pi / 4.0 * radius**4
    shear = SHEAR * pin.lame[1] * np.pi * radius**2
    return np.asarray(step * (moment @ moment.T / bending + cut @ cut.T / shear))


def pressures(
    flexibility: Floats, areas: Floats, resultants: Floats, load: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Find the pressures of a pin that fits, with a given resultant, by an active set.

    Rounds that change all wrong faces may repeat themselves on a coarse bore. Non-negative least squares find
    the pressed faces then, as those of the least energy.

    Parameters
    ----------
    flexibility : array (f, f)
        Work of unit pressures on the displacement by unit pressures, of body and pin together, m3/Pa.
    areas : array (f,)
        In m2.
    resultants : array (f, 4)
        Forces (m2) and moments (m3) of unit pressures across the bore; the pin moves freely along these.
    load : array (4,)
        Resultant of the pressures, N and N m.

    Returns
    -------
    pressures : array (f,)
        In Pa, not negative.
    pressed : array (f,) of bool

    Raises
    ------
    RuntimeError
        If no pressures without tension have the resultant.
    """
    pressed = resultants @ load > 0.0
    fewest = len(load)
    for _ in range(ROUNDS):
        if pressed.sum() < fewest:
            break
        found = np.zeros(len(areas))
        found[pressed], motion = _balanced(flexibility, resultants, pressed, load)
        gap = (flexibility @ found - resultants @ motion) / areas
        tension = found < -ROUNDING * found.max()
        closed = gap < -ROUNDING * np.abs(gap).max()
        wrong = np.flatnonzero(np.where(pressed, tension, closed))
        if not len(wrong):
            return np.maximum(found, 0.0), pressed
        pressed = pressed.copy()
        pressed[wrong] = ~pressed[wrong]
    root = np.linalg.cholesky(flexibility).T
    firm = FIRM * np.linalg.norm(root) / np.linalg.norm(resultants, axis=0)
    least, _ = nnls(
        np.vstack((root, (resultants * firm).T)), np.concatenate((np.zeros(len(root)), load * firm))
    )
    pressed = least > 0.0
    found = np.zeros(len(areas))
    if pressed.sum() >= fewest:
        found[pressed], _ = _balanced(flexibility, resultants, pressed, load)
    if pressed.sum() < fewest or found.min() < -NEARLY * found.max():
        raise RuntimeError("the pin must find faces that bear its force, got a bore with too few of them")
    return np.maximum(found, 0.0), pressed


def _balanced(
    flexibility: Floats, resultants: Floats, pressed: NDArray[np.bool_], load: Floats
) -> tuple[Floats, Floats]:
    """Return the pressures on pressed faces without a gap, and the motion (4,) of the pin."""
    own = resultants[pressed]
    count = len(own)
    size = np.diag(flexibility).mean() / np.abs(resultants).max(axis=0)
    matrix = np.zeros((count + 4, count + 4))
    matrix[:count, :count] = flexibility[np.ix_(pressed, pressed)]
    matrix[:count, count:] = -own * size
    matrix[count:, :count] = -(own * size).T
    answer = np.linalg.solve(matrix, np.concatenate((np.zeros(count), -load * size)))
    return answer[:count], answer[count:] * size


@dataclass(frozen=True, eq=False)
class PinContact:
    """Pressures of a pin on f faces of its bore: of unit forces in d directions, then of unit moments.

    Attributes
    ----------
    name : str
        Name of the interface.
    bore : BoreFaces
    pressures : array (f, 2 d)
        In Pa per N and per N m. A moment moves the force of the same direction along the bore.
    """

    name: str
    bore: BoreFaces
    pressures: Floats

    @property
    def nodal(self) -> csr_array:
        """Nodal forces (3n, 2 d) in N per N and per N m."""
        return csr_array(self.bore.loads @ csr_array(self.pressures))

    @property
    def resultants(self) -> Floats:
        """Force and moment (6, 2 d) of the pressures about the joint centre, body axes."""
        return np.asarray(self.bore.resultants.T @ self.pressures)

    @property
    def directions(self) -> int:
        """Number of directions."""
        return self.pressures.shape[1] // 2

    def coordinates(self, loads: Floats) -> Floats:
        """Return the coordinates (t, 2 d) of forces and moments (t, 6) on the joint centre, body axes.

        A force acts in the two directions beside its own. Its part along the bore, and a moment beyond the
        eccentricity `KERN` or about the force, have none: they stay with the coupling.
        """
        count = self.directions
        step = 2.0 * np.pi / count
        force = loads[:, :3] @ self.bore.axes[:2].T
        size = np.linalg.norm(force, axis=1)
        angle = np.arctan2(force[:, 1], force[:, 0]) % (2.0 * np.pi)
        first = (angle / step).astype(int) % count
        beyond = angle - first * step
        shares = np.stack((np.sin(step - beyond), np.sin(beyond)), axis=1) / np.sin(step)
        along = np.stack((np.cos(angle), np.sin(angle)), axis=1) @ self.bore.axes[:2]
        moment = np.einsum("tc,tc->t", loads[:, 3:], np.cross(self.bore.axes[2], along))
        moment = np.clip(moment, -KERN * self.bore.length * size, KERN * self.bore.length * size)
        found = np.zeros((len(loads), 2 * count))
        rows = np.arange(len(loads))
        for number in (0, 1):
            place = (first + number) % count
            found[rows, place] += shares[:, number] * size
            found[rows, count + place] += shares[:, number] * moment
        return found


def pin_contact(
    partition: Partition, interface: Interface, pin: Material, directions: int = DIRECTIONS
) -> PinContact:
    """Find the pressures of a pin in its bore, by direction of its force.

    Parameters
    ----------
    partition : Partition
        Partition whose couplings do not stiffen the body.
    interface : Interface
        Bore of the pin.
    pin : Material
        Material of the pin.
    directions : int
        Number of directions.

    Raises
    ------
    ValueError
        If a coupling is rigid, or the interface has no faces.
    RuntimeError
        See `pressures`.
    """
    if stiff := [other.name for other in partition.interfaces if other.spider == "rigid"]:
        raise ValueError(f"pins in contact need bores that are free to bend, got rigid couplings of {stiff}")
    bore = bore_faces(partition.body.mesh, interface)
    count = bore.loads.shape[1]
    flexibility = pin_flexibility(bore, pin)
    for start in range(0, count, AT_ONCE):
        columns = slice(start, start + AT_ONCE)
        answers = partition.static_response(bore.loads[:, columns].toarray())
        flexibility[:, columns] += bore.loads.T @ answers
    flexibility = 0.5 * (flexibility + flexibility.T)
    across = np.concatenate(
        (bore.resultants[:, :3] @ bore.axes[:2].T, bore.resultants[:, 3:] @ bore.axes[:2].T), axis=1
    )
    areas = bore.areas.sum(axis=1)
    fields = np.zeros((count, 2 * directions))
    for k in range(directions):
        angle = 2.0 * np.pi * k / directions
        way = np.array([np.cos(angle), np.sin(angle)])
        fields[:, k], pressed = pressures(flexibility, areas, across, np.array([*way, 0.0, 0.0]))
        turn = np.cross(bore.axes[2], way @ bore.axes[:2]) @ bore.axes[:2].T
        fields[pressed, directions + k], _ = _balanced(
            flexibility, across, pressed, np.array([0.0, 0.0, *turn])
        )
    return PinContact(interface.name, bore, fields)


def contact_loads(
    contacts: Sequence[PinContact], interfaces: Sequence[Interface], nodes: int
) -> tuple[csr_array, Floats]:
    """Return the unit loads of pins in contact less those of their couplings, in balance with these.

    Parameters
    ----------
    contacts : sequence of PinContact
    interfaces : sequence of Interface
        All i interfaces of the body.
    nodes : int
        Number n of nodes of the body.

    Returns
    -------
    nodal : sparse array (3n, k)
        Nodal forces of the pressures, N per coordinate; k coordinates of all contacts one after another.
    centers : array (6 i, k)
        Force and moment on each joint centre that take the resultants of the pressures away, N and N m.
    """
    names = [interface.name for interface in interfaces]
    if not contacts:
        return csr_array((3 * nodes, 0)), np.zeros((6 * len(names), 0))
    nodal = csr_array(hstack([contact.nodal for contact in contacts]))
    centers = np.zeros((len(names), 6, nodal.shape[1]))
    first = 0
    for contact in contacts:
        columns = slice(first, first + contact.pressures.shape[1])
        centers[names.index(contact.name), :, columns] = -contact.resultants
        first = columns.stop
    return nodal, centers.reshape(-1, nodal.shape[1])


def contact_coordinates(
    contacts: Sequence[PinContact], interfaces: Sequence[Interface], loads: Floats
) -> Floats:
    """Return the coordinates (t, k) of `contact_loads` by forces and moments (t, i, 6) on joint centres."""
    names = [interface.name for interface in interfaces]
    each = [contact.coordinates(loads[:, names.index(contact.name)]) for contact in contacts]
    return np.concatenate([np.zeros((len(loads), 0)), *each], axis=1)
