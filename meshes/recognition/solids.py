"""Solids of STEP files and closed STL boundaries, meshed by netgen with its own CAD kernel."""

import importlib
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fem.body.distortion import straighten_distorted
from fem.body.mesh import Floats, Integers, MeshError
from meshes import mesher
from meshes.build_shoe import FROM_NETGEN
from meshes.recognition import slivers, step_units
from meshes.recognition.axes import Question
from meshes.recognition.step_units import StepUnit
from meshes.recognition.triangles import Triangles

SEND_STEP = "send the shoe as STEP, or as a mesh of tetrahedra"
QUICK = 0.06
"""Greatest edge of the mesh for the search of bores, fraction of the extent."""
QUICK_CURVES = 2.0
CURVES = 1.0
"""Elements along a curve's radius, in the search (`QUICK_CURVES`) and in the shoe."""
GROWTH = 0.3
MM = StepUnit("mm", 1e-3)
EQUAL = 1e-6
"""Relative difference of the volumes of equal solids."""
OPEN = 1e-9
"""Share of edges with one triangle, or three, above which a boundary is not closed."""


class SizesOfElements(NamedTuple):
    """Greatest edges of elements, fractions of the pitch and of a bore's radius."""

    of_pitch: float
    of_bores: float


SIZES = {
    "coarse": SizesOfElements(0.2, 0.67),
    "study": SizesOfElements(0.125, 0.4),
    "fine": SizesOfElements(0.085, 0.25),
}
"""Resolutions similar to the ready meshes of these names."""


def netgen_module(name: str, for_what: str) -> Any:
    """Return a module of netgen; a `ModuleNotFoundError` says what needs it and how to install it."""
    mesher.require_netgen(for_what)
    module = importlib.import_module(f"netgen.{name}")
    from netgen import libngpy

    libngpy._meshing.SetMessageImportance(0)
    return module


class ApartError(MeshError):
    """Error for a file with several solids that do not touch.

    Attributes
    ----------
    apart : float
        Distance of the largest solid from the nearest equal one, mm; 0 if not all are equal.
    count : int
    """

    def __init__(self, text: str, apart: float = 0.0, count: int = 0) -> None:
        super().__init__(text)
        self.apart = apart
        self.count = count


class StepSolid:
    """Solid of a STEP file, in mm, since netgen converts any unit.

    Attributes
    ----------
    shape : TopoDS_Shape
    unit : StepUnit or None
        Unit named by the file; None if it names none: numbers then count as mm.
    healed : tuple of Sliver
    Removed slivers.
    questions : list of Question

    Raises
    ------
    ModuleNotFoundError
        If netgen is not installed.
    MeshError
    If the file is not STEP, has no solid, or has several that do not touch without a choice.
    """

    def __init__(self, path: Path, body: str | None = None) -> None:
        self._occ = netgen_module("occ", "a STEP file")
        with path.open("rb") as file:
            if not file.read(4096).lstrip().startswith(b"ISO-10303-21"):
                raise MeshError(f"{path} must be a STEP file, which begins with ISO-10303-21")
        units = step_units.units_of(path)
        if len(units) > 1:
            names = ", ".join(unit.name for unit in units)
            raise MeshError(f"{path} must be in one unit of length, its parts are in {names}")
        self.unit = units[0] if units else None
        mesher.begin_step("the reading of the file")
        try:
            whole = self._occ.OCCGeometry(str(path)).shape
            solids = sorted(whole.solids, key=lambda solid: -solid.mass)
        except Exception as error:  # the kernel raises all kinds of errors
            raise MeshError(f"{path} must be a STEP file that can be read: {_line(error)}") from error
        if not solids:
            raise MeshError(
                f"{path} must hold a solid, got surfaces or nothing; sew them to a solid, or export it"
            )
        self.questions: list[Question] = []
        self.shape = self._chosen(path, solids, body)
        found = slivers.find_slivers(self.shape)
        self.healed: tuple[slivers.Sliver, ...] = ()
        self._suspects = slivers.suspects(found, self.unit or MM)
        if found:
            mesher.begin_step("the removal of slivers", self._suspects)
            if (shape := slivers.healed(self._occ, self.shape)) is not None:
                self.shape = shape
                self.healed = tuple(found)

    def _chosen(self, path: Path, solids: list[Any], body: str | None) -> Any:
        unit = self.unit or MM
        cubed = (MM.metres / unit.metres) ** 3
        volumes = ", ".join(
            f"{number}: {cubed * solid.mass:.4g} {unit.name}3"
            for number, solid in enumerate(solids[:8], start=1)
        )
        if body not in (None, "all"):
            return solids[body_number(body, len(solids), volumes) - 1]
        if len(solids) == 1:
            return solids[0]
        mesher.begin_step("the fusion of its solids")
        try:
            fused = solids[0]
            for solid in solids[1:]:
                fused = fused + solid
            parts = list(fused.solids)
        except Exception as error:  # the kernel raises all kinds of errors
            raise MeshError(f"{path}: its {len(solids)} solids cannot be fused: {_line(error)}") from error
        if len(parts) != 1:
            raise ApartError(
                f"{path} must hold one solid, or several that touch, got {len(parts)} apart of {volumes}; "
                "--body N chooses one",
                _distance_of_equals(solids),
                len(solids),
            )
        if body is None:
            self.questions = [
                Question("--body N", f"{len(solids)} solids were fused to a body of one material, {volumes}")
            ]
        return parts[0]

    def quick(self) -> tuple[Triangles, Integers]:
        """Return the triangles of a mesh for the search of bores, and the solid's face number of each."""
        mesher.begin_step("the meshing of its surface", self._suspects)
        mesh = self._generate(QUICK * slivers.extent_of(self.shape), QUICK_CURVES, surface=True)
        sides = mesh.Elements2D().NumPy()
        triangles = Triangles(np.array(mesh.Coordinates()), sides["nodes"][:, :3].astype(np.int64) - 1)
        return triangles.outward(), sides["index"].astype(np.int64)

    def refine(self, faces: Integers, size: float) -> None:
        """Set the greatest edge, mm, on faces of the solid."""
        for number in np.unique(faces):
            self.shape.faces[int(number) - 1].maxh = size

    def mesh(self, size: float) -> tuple[Floats, Integers, int]:
        """Return nodes (mm), tetrahedra of 10 nodes with edges up to a size, and the number straightened."""
        mesher.begin_step("the meshing of the solid", self._suspects)
        mesh = self._generate(size, CURVES)
        mesh.SecondOrder()
        return second_order(mesh)

    def _generate(self, size: float, curves: float, surface: bool = False) -> Any:
        steps = self._occ
        last = ""
        for finer in (1.0, 1.5, 2.5):
            how = {"maxh": size / finer, "grading": GROWTH, "segmentsperedge": 0.5}
            if surface:
                from netgen.meshing import MeshingStep

                how["perfstepsend"] = MeshingStep.MESHSURFACE
            try:
                return steps.OCCGeometry(self.shape).GenerateMesh(curvaturesafety=finer * curves, **how)
            except Exception as error:  # netgen raises all kinds of errors
                last = _line(error)
        remedy = self._suspects or "heal it in CAD, or send a mesh of tetrahedra"
        raise MeshError(f"netgen cannot mesh the solid: {last}; {remedy}")


def _distance_of_equals(shapes: list[Any]) -> float:
    """Return the distance of the first of equal solids to the nearest other, mm; 0 if they differ."""
    first = shapes[0]
    if any(abs(shape.mass / first.mass - 1.0) > EQUAL for shape in shapes):
        return 0.0
    return min(math.dist(tuple(first.center), tuple(shape.center)) for shape in shapes[1:])


def body_number(body: str, count: int, held: str) -> int:
    """Return the number of a chosen body, from 1; a `MeshError` lists the bodies."""
    if not body.isdecimal() or not 1 <= int(body) <= count:
        raise MeshError(f"--body must be a number in 1..{count}, the largest first ({held}), got {body!r}")
    return int(body)


def second_order(mesh: Any) -> tuple[Floats, Integers, int]:
    """Return nodes and elements of a second-order netgen mesh, and the number of straightened elements."""
    elements = mesh.Elements3D().NumPy()["nodes"][:, FROM_NETGEN].astype(np.int64) - 1
    nodes, count = straighten_distorted(np.array(mesh.Coordinates()), elements)
    return nodes, elements, count


def fill_boundary(triangles: Triangles, size: float) -> tuple[Floats, Integers]:
    """Fill a closed boundary with tetrahedra that keep its triangles, with edges up to a size.

    Raises
    ------
    ModuleNotFoundError
        If netgen is not installed.
    MeshError
    If the boundary is not closed, or netgen cannot fill it.
    """
    mesher.require_netgen("an STL file")
    if triangles.open_share > OPEN:
        raise MeshError(
            f"its boundary must be closed, got {100.0 * triangles.open_share:.2g} % of edges that have not "
            f"two triangles; {SEND_STEP}"
        )
    return mesher.call(_filled, triangles, size)


def _filled(triangles: Triangles, size: float) -> tuple[Floats, Integers]:
    """Fill a closed boundary in the mesher's process."""
    meshing = netgen_module("meshing", "an STL file")
    mesher.begin_step("the filling of the boundary", SEND_STEP)
    mesh = meshing.Mesh()
    mesh.Add(meshing.FaceDescriptor(surfnr=1, domin=1, bc=1))
    mesh.AddPoints(np.ascontiguousarray(triangles.points))
    mesh.AddElements(dim=2, index=1, data=np.ascontiguousarray(triangles.faces.astype(np.int32)), base=0)
    try:
        mesh.GenerateVolumeMesh(maxh=size, grading=GROWTH)
    except Exception as error:  # netgen raises all kinds of errors
        raise MeshError(
            f"netgen cannot fill its boundary with tetrahedra: {_line(error)}; {SEND_STEP}"
        ) from error
    nodes = mesh.Elements3D().NumPy()["nodes"]
    if not len(nodes):
        raise MeshError(f"netgen cannot fill its boundary with tetrahedra; {SEND_STEP}")
    return np.array(mesh.Coordinates()), nodes[:, FROM_NETGEN[:4]].astype(np.int64) - 1


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or repr(error)
