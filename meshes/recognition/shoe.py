"""Shoes of makers' files in the program's form, from STEP, STL or tetrahedra in any unit and axes."""

import itertools
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np

from fem.body.mesh import Floats, Integers, Mesh, MeshError, boundary_faces
from fem.files.mesh_content import VolumeMesh
from fem.files.mesh_files import read_volume
from meshes import mesher
from meshes.load_surfaces import with_known_names
from meshes.recognition import bores, elements as tetrahedra, pins, quality, solids
from meshes.recognition.axes import UNITS, Choices, NodesUnit, Question, ShoeAxes, find_axes
from meshes.recognition.pins import PinPair
from meshes.recognition.step_units import StepUnit
from meshes.recognition.surfaces import ShoeSurfaces, find_surfaces
from meshes.recognition.triangles import Triangles

STEP_FILES = (".step", ".stp")
STL_FILES = (".stl",)
SAME_AXES = 1e-3
"""Greatest difference between two meshes of one solid: angle of the axes, rad, and relative pitch."""
SAME_PIN_HEIGHT = 1e-3
"""Tolerance between front and rear pin heights, m: a level shoe has them at one height."""
FEWEST_TRIANGLES = 20
FLATTEST = 1e-3
FLAT = 0.05
"""Limits of element shapes (1 for a regular one): flatter ones spoil all results, or the stress beside
them."""
DOUBLE_PINS = 0.5
"""Least distance between the lines of two pins, fraction of the extent."""
EQUAL_LINES = 0.9
"""Overlap of equal lines, such as those of two pins in connectors, fraction of the longer line's length."""


class FileSolid(NamedTuple):
    """Tetrahedra of a file.

    Attributes
    ----------
    nodes : array (n, 3)
        Nodes in the file's unit and axes.
    elements : int array (m, 10)
    unit : NodesUnit or None
        Unit of the nodes and that of the file, if the file names one.
    surfaces : dict of str to int array (k, 6)
        Surfaces named by the file.
    remarks : tuple of str
    questions : tuple of Question
    """

    nodes: Floats
    elements: Integers
    unit: NodesUnit | None
    surfaces: dict[str, Integers]
    remarks: tuple[str, ...] = ()
    questions: tuple[Question, ...] = ()


@dataclass(frozen=True, eq=False)
class RecognizedShoe:
    """Shoe of a file in its own axes, with the data of its chain.

    Attributes
    ----------
    mesh : Mesh
        Mesh in m, x ahead, y to the left, z up, origin at the COM; with all named surfaces.
    axes : ShoeAxes
    surfaces : ShoeSurfaces
    unit : str
        Unit of the file, and its origin.
    remarks : tuple of str
        Omissions and changes.
    questions : tuple of Question
        Choices that geometry leaves open.
    """

    mesh: Mesh
    axes: ShoeAxes
    surfaces: ShoeSurfaces
    unit: str
    remarks: tuple[str, ...]
    questions: tuple[Question, ...]

    @property
    def pitch(self) -> float:
        """Distance of front and rear pins, m."""
        return float(self.pin_ahead - self.axes.place_of(self.axes.pins.lines[0])[0])

    @property
    def pin_ahead(self) -> float:
        """X of the front pins, m."""
        return float(self.axes.place_of(self.axes.pins.lines[1])[0])

    @cached_property
    def pin_height(self) -> float:
        """Z of all pins, m; raises `ValueError` if front and rear pins are not at one height."""
        rear, front = (float(self.axes.place_of(line)[2]) for line in self.axes.pins.lines)
        if abs(front - rear) > SAME_PIN_HEIGHT:
            raise ValueError(
                "front and rear pins must be at one height above the underside within "
                f"{1e3 * SAME_PIN_HEIGHT:g} mm, as in a level track, the front pins are "
                f"{1e3 * (front - rear):+.3g} mm higher"
            )
        return 0.5 * (rear + front)

    @property
    def joint_y(self) -> tuple[float, float]:
        """Y of the right and of the left joint, m."""
        return self.surfaces.joint_y

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of the rear and of the front bores, m."""
        rear, front = (line.radius * self.axes.scale for line in self.axes.pins.lines)
        return rear, front


def recognize_file(path: str | Path, choices: Choices | None = None, size: str = "study") -> RecognizedShoe:
    """Read a maker's file of a shoe and recognize its parts.

    Parameters
    ----------
    path : str or Path
        STEP, STL, or a mesh of tetrahedra as `fem.read_volume` reads it.
    choices : Choices, optional
        User's decisions.
    size : str
        "coarse", "study" or "fine": resolution if the solid is meshed here.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ModuleNotFoundError
        If the file needs netgen, and netgen is not installed.
    MeshError
        If the file cannot be read or meshed.
    ValueError
        If the file is no shoe, or the choices do not fit it.
    """
    path = Path(path)
    choices = choices or Choices()
    if not path.is_file():
        raise FileNotFoundError(f"no file {path}")
    if size not in solids.SIZES:
        raise ValueError(f"size must be one of {', '.join(solids.SIZES)}, got {size!r}")
    try:
        return recognize_solid(read_solid(path, choices, solids.SIZES[size]), choices)
    except MeshError as error:
        text = str(error)
        raise MeshError(text if text.startswith(str(path)) else f"{path}: {text}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def read_solid(path: Path, choices: Choices, size: solids.SizesOfElements) -> FileSolid:
    """Read the tetrahedra of 10 nodes of a file; parameters and errors are those of `recognize_file`."""
    suffix = path.suffix.lower()
    if suffix in STEP_FILES:
        mesher.require_netgen("a STEP file")
        return mesher.call(_of_step, path, choices, size)
    if suffix in STL_FILES:
        return _of_stl(path, choices, size)
    return _of_mesh(read_volume(path), choices)


def recognize_solid(solid: FileSolid, choices: Choices) -> RecognizedShoe:
    """Find a shoe's axes, unit and surfaces from its boundary; errors are those of `recognize_file`."""
    rows = boundary_faces(solid.elements)
    triangles = Triangles(solid.nodes, rows[:, :3])
    axes = axes_of(triangles, choices, solid.unit)
    axes = replace(axes, origin=tetrahedra.centroid(solid.nodes, solid.elements))
    surfaces = find_surfaces(triangles, axes, choices.footprint)
    named = {name: rows[numbers] for name, numbers in surfaces.faces.items()}
    nodes = (solid.nodes - axes.origin) @ axes.rows.T * axes.scale
    others = Mesh(nodes, solid.elements, solid.surfaces)
    others_of_file = {
        name: faces for name, faces in with_known_names(others).surfaces.items() if name not in named
    }
    known = sorted(set(with_known_names(others).surfaces) & set(named))
    remarks = [*solid.remarks, *differing_bores(axes), *surfaces.remarks]
    if known:
        remarks.append(f"surfaces of the file that the shape also gives are replaced: {', '.join(known)}")
    return RecognizedShoe(
        others.with_surfaces(named) if not known else Mesh(nodes, solid.elements, others_of_file | named),
        axes,
        surfaces,
        _unit_words(solid.unit, choices, axes),
        tuple(remarks),
        (*solid.questions, *axes.questions, *surfaces.questions),
    )


def _unit_words(named: NodesUnit | None, choices: Choices, axes: ShoeAxes) -> str:
    """Return the unit of a file and its origin."""
    if named is not None:
        return f"{named.name}, named by the file"
    return f"{axes.unit}, by --unit" if choices.unit else f"{axes.unit}, by the size of the shoe"


def differing_bores(axes: ShoeAxes) -> Iterator[str]:
    """Yield a remark for each end whose bores have different radii."""
    size = 1e3 * axes.scale
    for end, line in zip(("rear", "front"), axes.pins.lines, strict=True):
        if line.has_equal_radii:
            continue
        bores = sorted(
            (size * (bore.middle - axes.origin) @ axes.rows[1], bore.radius) for bore in line.bores
        )
        words = ", ".join(f"{size * radius:.3f} mm at y = {y:.4g} mm" for y, radius in bores)
        yield f"the {end} bores have different radii, {words}: is one worn, or bored for another pin?"


def axes_of(triangles: Triangles, choices: Choices, unit: NodesUnit | None = None) -> ShoeAxes:
    """Return axes and unit of a shoe from the bores on its boundary.

    Raises
    ------
    ValueError
        If no two lines of bores make a chain; the message lists the bores.
    """
    lines = pins.pin_lines(bores.find_bores(triangles))
    pairs = pins.pin_pairs(triangles, lines)
    if not pairs:
        raise ValueError(_no_pins(triangles, lines, unit))
    if not 1 <= choices.pins <= len(pairs):
        raise ValueError(
            f"--pins must be in 1..{len(pairs)}, the pairs of bores that make a chain, got {choices.pins}"
        )
    chosen = pins.refined(triangles, pairs.pop(choices.pins - 1))
    return find_axes(triangles, [chosen, *pairs], choices, unit)


def _no_pins(triangles: Triangles, lines: list[pins.PinLine], unit: NodesUnit | None) -> str:
    """Return the reason why a shoe has no pins of a chain."""
    length = unit.of_nodes if unit else "units of the file"
    held = [f"{len(line.bores)} of radius {line.radius:.4g} {length}" for line in lines if line.length > 0.0]
    words = "; ".join(held[:8]) + (f" and {len(held) - 8} more" if len(held) > 8 else "")
    reason = (
        "it must have round bores at both ends whose lugs stand between those of its neighbours, "
        f"got {f'lines of {words}' if held else 'no round hole'}"
    )
    if (pair := _overlapping_lines(triangles, lines)) is None:
        return reason
    first, second = (line.spans(pair[0].axis) for line in pair)
    beside = pins.overlap_of_spans(first, second)
    reason += (
        f"; if the lines of radius {pair[0].radius:.4g} and {pair[1].radius:.4g} {length} are the pins, "
        f"front and rear lugs overlap by {beside.max():.4g} {length} along them, and neighbours would meet: "
        "lugs have to stand beside each other"
    )
    whole = max(line.length for line in pair)
    if beside.sum() > EQUAL_LINES * whole:
        reason += "; a track with two pins a link and connectors, whose lines are equal, is not covered"
    return reason


def _overlapping_lines(
    triangles: Triangles, lines: list[pins.PinLine]
) -> tuple[pins.PinLine, pins.PinLine] | None:
    """Return the likeliest two distant lines of bores that overlap, or None."""
    found = []
    for first, second in itertools.combinations(lines, 2):
        if abs(first.axis @ second.axis) < pins.PARALLEL:
            continue
        apart = bores.across(second.point, first.axis, first.point)
        far = float(np.linalg.norm(apart))
        extent = np.ptp(triangles.points @ (apart / max(far, 1e-300)))
        radii = sorted((first.radius, second.radius))
        least = min(first.length, second.length)
        beside = pins.overlap(first.spans(first.axis), second.spans(first.axis))
        if far > DOUBLE_PINS * extent and radii[1] < pins.RADII * radii[0] and beside > pins.OVERLAP * least:
            found.append((least * far * radii[0], (first, second)))
    return max(found, key=lambda one: one[0])[1] if found else None


def _of_step(path: Path, choices: Choices, size: solids.SizesOfElements) -> FileSolid:
    """Mesh the solid of a STEP file; bores found on a quick surface mesh get small elements."""
    solid = _step_solid(path, choices.body)
    unit = _checked_unit(solid.unit, choices)
    triangles, face = solid.quick()
    try:
        guess = axes_of(triangles, choices, unit)
    except ValueError as error:
        if not solid.questions:
            raise
        raise ValueError(
            f"{error}; {solid.questions[0].words}: pins and bushes among them fill bores, "
            f"{solid.questions[0].flag} takes a single one"
        ) from error
    pair: PinPair = guess.pins
    for line in pair.lines:
        solid.refine(face[line.faces], size.of_bores * line.radius)
    nodes, elements, straightened = solid.mesh(size.of_pitch * pair.pitch)
    final = axes_of(Triangles(nodes, boundary_faces(elements)[:, :3]), choices, unit)
    turned = np.arccos(np.clip((np.trace(final.rows @ guess.rows.T) - 1.0) / 2.0, -1.0, 1.0))
    if turned > SAME_AXES or abs(final.pins.pitch / pair.pitch - 1.0) > SAME_AXES:
        raise ValueError(
            "the shoe must be the same on any mesh, but its axes differ by "
            f"{np.degrees(turned):.3g} degrees and its pitch by {final.pins.pitch - pair.pitch:.3g} mm "
            "between two: mesh it finer (--size fine)"
        )
    remarks = [f"meshed by netgen: {len(nodes)} nodes, {len(elements)} elements"]
    if unit is None:
        remarks.append(
            f"the file names no unit of length, {final.unit} was taken: export the shoe with its unit"
        )
    if solid.healed:
        first = solid.healed[0].words(solid.unit or solids.MM)
        remarks.append(f"{len(solid.healed)} slivers were removed, the smallest {first}")
    if straightened:
        remarks.append(f"{straightened} elements have straight edges, which curved ones would have folded")
    return FileSolid(nodes, elements, unit, {}, tuple(remarks), tuple(solid.questions))


def _step_solid(path: Path, body: str | None) -> solids.StepSolid:
    """Read the solid of a STEP file; the error says so if the file has several links."""
    try:
        return solids.StepSolid(path, body)
    except solids.ApartError as error:
        if not error.apart:
            raise
        try:
            first = solids.StepSolid(path, "1")
            pair = axes_of(first.quick()[0], Choices(), _checked_unit(first.unit, Choices())).pins
        except ValueError:
            raise error from None
        if abs(error.apart / pair.pitch - 1.0) > SAME_AXES:
            raise
        raise MeshError(
            f"{error}; they are {error.count} equal links, one pitch apart: --body 1 takes one"
        ) from error


def _checked_unit(unit: StepUnit | None, choices: Choices) -> NodesUnit | None:
    """Return the unit of a STEP file's nodes (netgen: mm); raise `ValueError` if the user names another."""
    if unit is None:
        return None
    if choices.unit and not unit.is_same(UNITS[choices.unit]):
        raise ValueError(
            f"--unit {choices.unit} contradicts the file, which names {unit.name}: leave the flag out, or "
            "export the shoe again in its unit"
        )
    return NodesUnit("mm", *unit)


def _of_stl(path: Path, choices: Choices, size: solids.SizesOfElements) -> FileSolid:
    """Fill a closed STL boundary with tetrahedra; its triangles stay unchanged."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # from text bytes that are read as a number
            # `meshio.read` ends the process if its reader fails
            raw = meshio.stl.read(path)
        parts = [block.data for block in raw.cells if block.type == "triangle"]
        triangles = Triangles.welded(np.asarray(raw.points, float), np.concatenate(parts).astype(np.int64))
    except Exception as error:  # meshio's readers raise all kinds of errors
        reason = " ".join(str(error).split()) or repr(error)
        raise MeshError(f"{path} must be an STL file that can be read: {reason}") from error
    if len(triangles.faces) < FEWEST_TRIANGLES or not np.isfinite(triangles.points).all():
        raise MeshError(f"{path} must be a closed boundary of triangles, got {len(triangles.faces)}")
    triangles = triangles.outward()
    pair = axes_of(triangles, choices).pins
    nodes, corners = solids.fill_boundary(triangles, size.of_pitch * pair.pitch)
    corners = tetrahedra.peeled(corners, quality.shapes(nodes, corners) < FLATTEST)
    flattest = float(quality.shapes(nodes, corners).min())
    if flattest < FLATTEST:
        raise MeshError(
            f"{path}: slivers among the triangles of its boundary make elements as flat as {flattest:.1g} of "
            f"1 of a regular one, with which nothing can be computed; {solids.SEND_STEP}"
        )
    nodes, elements = tetrahedra.with_middles(nodes, corners)
    remarks = [
        f"filled by netgen: {len(nodes)} nodes, {len(elements)} elements; an STL file has flat triangles "
        "alone, on which edges are straight: bores and fillets are as coarse as in the file"
    ]
    if flattest < FLAT:
        remarks.append(
            f"slivers among its triangles make elements as flat as {flattest:.2g} of 1 of a regular one: "
            f"stress beside them means little; better {solids.SEND_STEP}"
        )
    return FileSolid(nodes, elements, None, {}, tuple(remarks))


def _of_mesh(content: VolumeMesh, choices: Choices) -> FileSolid:
    """Return the tetrahedra of one body in a mesh file."""
    nodes = content.nodes
    elements = content.elements
    surfaces = content.surfaces
    remarks = list(content.notes)
    remarks += [f"surface {name!r} is left out: {reason}" for name, reason in content.unread.items()]
    parts = tetrahedra.bodies(elements, len(nodes))
    body = choices.body
    held = ", ".join(f"{number}: {len(part)} elements" for number, part in enumerate(parts, 1))
    if body is None and len(parts) > 1:
        raise MeshError(
            f"the mesh must be one body, got {len(parts)} that share no nodes ({held}); --body N chooses "
            "one; parts that are bolted together must be meshed as one"
        )
    if body is not None and body in content.cell_sets:
        chosen: Integers | None = content.cell_sets[body]
    else:
        number = 1 if body in (None, "all") else solids.body_number(str(body), len(parts), held)
        chosen = parts[number - 1] if len(parts) > 1 else None
    if chosen is not None:
        nodes, elements, number_of = tetrahedra.renumbered(nodes, elements[chosen])
        rows = {tuple(face) for face in np.sort(boundary_faces(elements)[:, :3], axis=1).tolist()}
        surfaces = {name: number_of[faces] for name, faces in surfaces.items()}
        surfaces = {
            name: faces
            for name, faces in surfaces.items()
            if all(tuple(face) in rows for face in np.sort(faces[:, :3], axis=1).tolist())
        }
    if elements.shape[1] == 4:
        nodes, elements = tetrahedra.with_middles(nodes, elements)
        surfaces = {}
        remarks.append(
            "linear elements were given mid-side nodes on straight edges: the shape stays as coarse"
        )
    else:
        straight = replace(content, nodes=nodes, elements=elements).straightened()
        if (straight.nodes != nodes).any():
            remarks.append(straight.notes[-1])
        nodes = straight.nodes
    return FileSolid(nodes, elements, None, surfaces, tuple(remarks))
