"""Order of the elimination of a system's unknowns, and rows of its terms in the fronts."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from exudyn_crawler.model import elimination
from exudyn_crawler.model.assembler import Assembler
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.tables import FrontRows

Unknowns = list[int]


def fronts_of(
    assembler: Assembler, bodies: Bodies, terrain: Unknowns
) -> tuple[elimination.Fronts, FrontRows]:
    """Return the fronts of the assembled parts with the terrain's coordinates, and the rows of their terms.

    Shoes go first, then the links along the chain, last the terrain, other bodies and other multipliers. In a
    closed chain links with two pins go first, then every second one of the remaining links in turn. Terms
    that touch one part of the loop are then not carried round all of it.
    """
    count = assembler.mode_count
    coordinates = [
        [*range(first, first + 6), *(range(modal, modal + count) if modal >= 0 else ())]
        for first, modal in zip(bodies.coordinate.tolist(), bodies.modal.tolist(), strict=True)
    ]
    rows = _rows_by_name(assembler, len(terrain) + sum(map(len, coordinates)))
    chain: dict[int, Unknowns] = {}
    bearings: Unknowns = []
    hinges = assembler.hinges
    pins_of = Counter(pin.link for pin in hinges)
    rows_of = {pin.name: [row for name in pin.row_names for row in rows[name]] for pin in hinges}
    for pin in hinges:
        (chain.setdefault(pin.link, []) if pin.link else bearings).extend(rows_of[pin.name])
    of_pins = {name for pin in hinges for name in pin.row_names}
    others = [row for name, numbers in rows.items() if name not in of_pins for row in numbers]
    order = sorted(chain)
    if assembler.case.gear.loops:
        order.sort(key=lambda link: (pins_of[link] == 1, link & -link))
    shoes = coordinates[: assembler.shoes]
    rest = [unknown for body in coordinates[assembler.shoes :] for unknown in body]
    groups = [*shoes, *(chain[link] for link in order), [*terrain, *rest, *others, *bearings]]
    couplings = [[*shoe, *terrain] for shoe in shoes]
    couplings += [
        [*coordinates[assembler.body_of(marker)], *rows_of[pin.name]]
        for pin in hinges
        for marker in pin.markers
    ]
    for members, names in assembler.couplings:
        unknowns = [unknown for body in members for unknown in coordinates[body]]
        couplings.append([*unknowns, *(row for name in names for row in rows[name])])
    fronts = elimination.fronts_of(groups, couplings)
    return fronts, _front_rows(fronts, coordinates, terrain, [row for some in rows.values() for row in some])


def _rows_by_name(assembler: Assembler, first: int) -> dict[str, Unknowns]:
    """Return the numbers of the multipliers of every joint, starting at `first`."""
    rows = {}
    for name, count in assembler.row_names:
        rows[name] = list(range(first, first + count))
        first += count
    return rows


def _front_rows(
    fronts: elimination.Fronts,
    coordinates: Sequence[Unknowns],
    terrain: Unknowns,
    multipliers: Unknowns,
) -> FrontRows:
    """Return the rows in the fronts of bodies, terrain and multipliers."""
    places = [{unknown: row for row, unknown in enumerate(fronts.rows(f))} for f in range(len(fronts.pivots))]
    front_of = {u: f for f, place in enumerate(places) for u in list(place)[: fronts.pivots[f]]}
    return FrontRows(
        np.array([[place.get(body[0], -1) for body in coordinates] for place in places]),
        np.array([front_of[body[0]] for body in coordinates]),
        np.array([place.get(terrain[0], -1) if terrain else -1 for place in places]),
        np.array([[place.get(row, -1) for row in multipliers] for place in places]),
    )
