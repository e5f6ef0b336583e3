"""Slivers of CAD solids: search and healing of edges and faces too short or narrow for a mesh."""

from typing import Any, NamedTuple

from meshes.recognition.step_units import StepUnit

TINY = 2e-5
"""Size below which an edge or a face is a sliver, fraction of the solid's extent: 12 um on a shoe of 600
mm."""
SAME_VOLUME = 1e-5
"""Relative change of volume by healing above which the solid stays unchanged."""
MM = 1e-3


class Sliver(NamedTuple):
    """Short edge or narrow face.

    Attributes
    ----------
    kind : str
        "edge" or "face".
    size : float
        Length of the edge, mean width of the face, mm.
    place : tuple of float
        Middle of the edge or face in the axes of the file, mm.
    """

    kind: str
    size: float
    place: tuple[float, float, float]

    def words(self, unit: StepUnit) -> str:
        """Return size and place in the file's unit."""
        times = MM / unit.metres
        at = ", ".join(f"{times * value:.5g}" for value in self.place)
        noun = "an edge" if self.kind == "edge" else "a face"
        how = "long" if self.kind == "edge" else "wide"
        return f"{noun} {times * self.size:.3g} {unit.name} {how} at ({at}) {unit.name}"


def extent_of(shape: Any) -> float:
    """Return the longest side of a shape's box, mm."""
    low, high = shape.bounding_box
    return float(max(high.x - low.x, high.y - low.y, high.z - low.z))


def find_slivers(shape: Any) -> list[Sliver]:
    """Return short edges and narrow faces of a solid, the smallest first."""
    least = TINY * extent_of(shape)
    found = {Sliver("edge", *_measured(edge, edge.mass)) for edge in shape.edges if edge.mass < least}
    for face in shape.faces:
        around = sum(edge.mass for edge in face.edges)
        width = 2.0 * face.mass / around if around > 0.0 else 0.0
        if width < least:
            found.add(Sliver("face", *_measured(face, width)))
    return sorted(found, key=lambda sliver: sliver.size)


def _measured(part: Any, size: float) -> tuple[float, tuple[float, float, float]]:
    # an edge occurs once with each of its faces, with different rounding
    x, y, z = (round(value, 6) + 0.0 for value in part.center)
    return round(size, 9), (x, y, z)


def healed(occ: Any, shape: Any) -> Any | None:
    """Return a solid without its slivers; None if healing leaves some or changes the volume."""
    geometry = occ.OCCGeometry(shape)
    try:
        geometry.Heal(tolerance=TINY * extent_of(shape))
        solids = list(geometry.shape.solids)
    except Exception:  # the kernel raises all kinds of errors
        return None
    if len(solids) != 1 or abs(solids[0].mass / shape.mass - 1.0) > SAME_VOLUME:
        return None
    return None if find_slivers(solids[0]) else solids[0]


def suspects(slivers: list[Sliver], unit: StepUnit) -> str:
    """Return a message on slivers that may spoil a mesh, with the remedy; empty without slivers."""
    if not slivers:
        return ""
    count = f"{len(slivers)} slivers, the smallest " if len(slivers) > 1 else ""
    return (
        f"the solid has {count}{slivers[0].words(unit)}: repair it in CAD and export the shoe again, "
        "or send a mesh of tetrahedra"
    )
