"""Tables of `docs/fem.md`: the couplings of pins beside each other, at lugs and bores of the ready shoe."""

from typing import get_args

import numpy as np

import fem
import meshes
from exudyn_crawler.case import Track
from exudyn_crawler.model import reductions
from exudyn_crawler.model.shoe_mesh import pin_interfaces
from exudyn_crawler.results.checks.cases import ShoeCheck, ready_cases
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.checks.solve import solve_cases
from exudyn_crawler.results.stress.hot_spots import shoe_regions
from fem.body.element_stress import von_mises
from fem.body.interfaces import Spider

FORCE, MEGA = 1e6, 1e6
"""N, of a pin on its bore; Pa in a MPa."""
EVERY = 3
"""Number of steps of 10 degrees between the directions of the table."""
BORES = ("rear left", "front left")
CASES = ("turn 70/30, side force at one pin", "turn 100/0, side force at one pin", "drive push forward")
ROLLER = 574e3  # N, on a rail


def main(size: str = "study") -> None:
    """Print the highest stress by direction of one pin's force, and cycles to a crack of check cases."""
    body = fem.ElasticBody(meshes.shoe_mesh(size), meshes.STEEL)
    track = Track.ph4100c()
    parts = {
        spider: fem.Partition(body, pin_interfaces(body.mesh, size, track, spider))
        for spider in get_args(Spider)
    }
    nodes = body.mesh.nodes
    interfaces = parts["contact"].interfaces
    empty = [np.zeros((len(nodes), count, 0)) for count in (3, 6)]
    lugs = shoe_regions(fem.Shapes(body.mesh, meshes.STEEL, interfaces, *empty), track) == "lugs"
    contacts = fem.cached_pin_contacts(reductions.reductions_folder(), parts["contact"], meshes.STEEL)
    for name in BORES:
        k = [interface.name for interface in interfaces].index(name)
        x, _, z = (nodes - interfaces[k].center).T
        beside = np.hypot(x, z) < 2.0 * contacts[k].bore.radius
        places = {"root": lugs & ~beside, "beside": lugs & beside}
        places["bore"] = np.isin(np.arange(len(nodes)), interfaces[k].nodes)
        directions = np.arange(0, contacts[k].directions, EVERY)
        centers = np.zeros((6 * len(interfaces), len(directions)))
        centers[6 * k : 6 * k + 6] = FORCE * contacts[k].resultants[:, directions]
        for spider, partition in parts.items():
            pressed = FORCE * contacts[k].nodal[:, directions].toarray() if spider == "contact" else None
            moved = partition.static_response(pressed, None if spider == "contact" else centers)
            mises = von_mises(np.moveaxis(body.stress(moved.reshape(*nodes.shape, -1)), 2, 0)) / MEGA
            for place, mask in places.items():
                highest = [f"{value:.0f}" for value in mises[:, mask].max(axis=1)]
                print(f"{name}, {spider}, {place}: {' '.join(highest)} MPa by 30 degrees", flush=True)
    for spider in parts:
        check = ShoeCheck(mesh=size, pins=spider, levels=())
        shoe = CheckedShoe(check)
        chosen = tuple(case for case in ready_cases(shoe.outline, ROLLER) if case.name in CASES)
        found = solve_cases(check.with_(cases=chosen), shoe)
        print(spider)
        print(found.cycles[found.cycles["region"].isin(["lugs", "bores", "notches"])].to_string())


if __name__ == "__main__":
    main()
