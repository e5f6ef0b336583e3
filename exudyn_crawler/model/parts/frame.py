"""Side frame, or machine on two tracks: a body with wheels that press on the rails of the shoes."""

from collections.abc import Sequence

import numpy as np

from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.gear.running_gear import Bogie, RunningGear
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.model import shoe_mesh
from exudyn_crawler.model.assembler import DRIVE, Assembler, Body
from exudyn_crawler.model.bodies import second_moment
from exudyn_crawler.model.forces.impact import Flange
from exudyn_crawler.model.forces.treads import Rail
from exudyn_crawler.model.forces.wheels import ROLLED, Wheels
from exudyn_crawler.model.state import BEARING


def add(assembler: Assembler) -> None:
    """Add the frame with its holds, load and wheels; the drive moves it instead of a shoe."""
    case = assembler.case
    gear = case.part(RunningGear)
    start = gear.frame_start(case)
    parts = gear.frame_parts
    frame = assembler.add_body(
        Body(
            SIDE_FRAME,
            sum(part.mass for part in parts),
            np.sum([part.mass * part.com for part in parts], axis=0),
            np.sum([second_moment(part.mass, part.inertia, part.com) for part in parts], axis=0),
            np.array([*start, 0.0, 0.0, 0.0]),
        )
    )
    origin = assembler.add_marker(frame, np.zeros(3))
    drawn = origin
    if case.drive.slip is not None:
        height = case.drive.drawbar_height - start[2]
        drawn = assembler.add_marker(frame, np.array([0.0, 0.0, height]))
    assembler.drive = drawn, assembler.shoes - 1
    assembler.couple([frame], [DRIVE])
    assembler.hold(frame, gear.holds)
    assembler.add_load(origin)
    assembler.wheels = _wheels(assembler, frame)
    for shoe in range(assembler.shoes):
        assembler.couple([shoe, frame])


def _wheels(assembler: Assembler, frame: int) -> Wheels:
    """Return the wheels of the frame on the rails of the shoes; other parts may carry some of them."""
    case = assembler.case
    gear = case.part(RunningGear)
    rails = case.shoe.roller_path
    lines = shoe_mesh.strip_lines(gear, rails)
    middles = gear.middles
    wheels = gear.first_wheels(case)
    count = assembler.shoes // len(middles)
    first = count * np.repeat(np.arange(len(middles)), len(wheels))
    reduced = None if assembler.floating is None else assembler.floating.reduced
    strips = gear.strips
    play, stiffness, damping = gear.flange
    ahead = np.subtract.outer(gear.rollers, gear.rollers)
    on_a_rail = (ahead >= 0.0) & (ahead < rails.front - rails.rear + 2.0 * ROLLED)
    return Wheels(
        frames=np.full(len(first), frame),
        shoes=np.column_stack((first, first + count)),
        places=np.array([[(x, y + m, z) for y in lines] for m in middles for x, z, _ in wheels]),
        middles=np.repeat(middles, len(wheels)),
        radii=np.tile(wheels[:, 2], len(middles)),
        resistances=np.tile(gear.resistances, len(middles)),
        fading=gear.resistance_speed,
        law=Impact(gear.stiffness / strips, gear.exponent, gear.damping / strips, gear.damping_depth),
        flange=Flange(play, stiffness / len(lines), damping / len(lines)),
        height=gear.flange_height,
        rail=Rail(rails.rear, rails.front, rails.height),
        rows=shoe_mesh.rail_rows(reduced, gear, rails),
        spacing=shoe_mesh.station_spacing(rails),
        slots=max(2, int(on_a_rail.sum(axis=0).max())),  # of the upper run two
    )


def add_pivoted(
    assembler: Assembler,
    names: Sequence[str],
    reference: np.ndarray,
    parts: Sequence[tuple[Bogie | Arm, tuple[int, ...]]],
) -> list[int]:
    """Add bodies on pivots of the frame that carry some of its rollers; return their numbers, track by track.

    `parts` are those of one track with the numbers of their rollers, from 1; `reference` (tracks * parts, 6)
    are their poses at t = 0.
    """
    case = assembler.case
    gear = case.part(RunningGear)
    frame = assembler.body_named(SIDE_FRAME)
    rollers = [k for k, label in enumerate(gear.wheel_labels) if label.kind == "roller"]
    of_tracks = np.reshape(rollers, (gear.tracks, -1)).tolist()
    pivoted = [(wheels, *part) for wheels in of_tracks for part in parts]
    bodies = []
    for name, start, (wheels, part, carried) in zip(names, reference, pivoted, strict=True):
        x, z = part.pivot
        com = part.com[0], 0.0, part.com[1]
        body = assembler.add_body(Body.rigid(name, part.mass, inertia_tensor(part.inertia), start, com))
        axis = assembler.add_marker(frame, start[:3] - gear.frame_start(case))
        assembler.add_pin(axis, assembler.add_marker(body, np.zeros(3)), BEARING.format(name))
        for number in carried:
            carry(assembler, wheels[number - 1], body, (gear.rollers[number - 1] - x, -z))
        bodies.append(body)
    return bodies


def carry(assembler: Assembler, wheel: int, body: int, place: tuple[float, float]) -> None:
    """Make a body carry a wheel of the frame; `place` is x and z of the wheel's axis in that body, m."""
    case = assembler.case
    x, z = place
    wheels = assembler.wheels
    wheels.frames[wheel] = body
    wheels.middles[wheel] = 0.0
    wheels.places[wheel] = [
        (x, y, z) for y in shoe_mesh.strip_lines(case.part(RunningGear), case.shoe.roller_path)
    ]
    for shoe in range(*wheels.shoes[wheel]):
        assembler.couple([shoe, body])
