"""Conversion of a maker's file of a shoe to a mesh and a case, with derived and assumed values marked."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import tomlkit

import fem
from exudyn_crawler import files
from exudyn_crawler.case import Case, FlexibleShoes, LoadCycle, Shoe, Track, ph4100c
from exudyn_crawler.case.parameters.track import COUPLING, STEEL_DENSITY
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.machines.case_file import case_text
from exudyn_crawler.machines.datasheet import shoe_mesh as datasheet_meshes
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.files import passed_shoe
from exudyn_crawler.model import shoe_mesh
from exudyn_crawler.results.stress import basis
from exudyn_crawler.views import style
from meshes import STEEL, with_load_surfaces
from meshes.checks import check_whole
from meshes.recognition import quality
from meshes.recognition.axes import Choices
from meshes.recognition.picture import draw_recognized
from meshes.recognition.shoe import RecognizedShoe, recognize_file
from meshes.undersides import is_interleaved

MODES = 6
"""Number of elastic free-free modes in the table."""
MECHANISM = 1e-3
"""Fraction of the highest frequency in the table; a frequency below it is that of a mechanism."""
FILLED = 0.8
"""Fraction of the underside's rectangle; a smaller area on the ground is reported."""
GROUND_PRESSURE = ph4100c.PROPEL_LOAD / (ph4100c.TRACK["pitch"] * ph4100c.SHOE["width"])
"""Papers' load over pitch and width of a shoe (Pa), assumed for the loads on other shoes."""
MIDDLE_SHOE = ph4100c.MIDDLE_SHOE
DURATION = 2.0  # s
ASSUMED = (
    "flexible.youngs_modulus",
    "flexible.poissons_ratio",
    "flexible.density",
    "track.shoe_count",
    "track.first_com",
    "loads.phases.loads",
)
"""Values of the case that follow neither from the shape of a shoe nor from the papers' machine."""
MARK = "ASSUMED"


@dataclass(frozen=True, eq=False)
class ShoeFile:
    """Recognized shoe with the case of a track of such shoes.

    Attributes
    ----------
    recognized : RecognizedShoe
    mesh : Mesh
        With the surfaces that may carry the machine.
    case_file : CaseFile
    table : DataFrame
        Properties of the shoe: quantity, value, unit.
    refusals : tuple of str
        Reasons for which a run with flexible shoes would be refused.
    """

    recognized: RecognizedShoe
    mesh: fem.Mesh
    case_file: CaseFile
    table: pd.DataFrame
    refusals: tuple[str, ...]

    def lines(self) -> Iterator[str]:
        """Yield lines for reading: what was done, what is to be decided, what a flexible run would refuse."""
        yield from self.recognized.remarks
        shoe = self.case_file.case.shoe
        if shoe.ground_share < FILLED:
            yield (
                f"{shoe.ground_area:.4g} m2 press on the ground, {100.0 * shoe.ground_share:.0f} % of the "
                f"underside's rectangle of {shoe.length:.4g} x {shoe.width:.4g} m"
            )
        if is_interleaved(self.mesh):
            yield (
                "the underside is longer than the pitch, and interleaves with those of its neighbours: "
                f"a rectangle of {shoe.length:.4g} x {shoe.width:.4g} m stands for it"
            )
        yield "the front is the end with the outer lugs; use --flip-front if it is the other one"
        for question in self.recognized.questions:
            yield f"to be decided: {question}"
        for reason in self.refusals:
            yield f"flexible shoes would be refused: {reason}"


def shoe_of(
    path: str | Path, choices: Choices | None = None, size: str = "study", name: str = ""
) -> ShoeFile:
    """Return the shoe of a maker's file with the case of a track of such shoes.

    `name` is that of the case, whose mesh is NAME.msh.gz; that of the file if not given. Errors are those of
    `meshes.recognition.shoe.recognize_file`; raises MeshError if the mesh is a mechanism or a surface is cut.
    """
    name = name or shoe_name(Path(path))
    recognized = recognize_file(path, choices, size)
    mesh = with_load_surfaces(recognized.mesh)
    check_whole(mesh, str(path))
    body = fem.ElasticBody(mesh, replace(STEEL, density=STEEL_DENSITY))
    frequencies = body.natural_frequencies(6 + MODES)[6:]
    if frequencies[0] < MECHANISM * frequencies[-1]:
        raise fem.MeshError(
            f"{path}: the mesh must be one stiff body, its first free-free frequency is "
            f"{frequencies[0]:.3g} Hz: parts of it are joined only at edges or corners"
        )
    surface = "whole top" if "whole top" in mesh.surfaces else "underside"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fem.MeshWarning)  # `check_whole` has warned with the name of the file
        shoe = Shoe.from_mesh(mesh, load_surface=surface)
    case_file = _case_file(recognized, mesh, shoe, name)
    return ShoeFile(
        recognized,
        mesh,
        case_file,
        _table(recognized, mesh, shoe, body, frequencies),
        tuple(_refusals(case_file.case, mesh)),
    )


def _case_file(recognized: RecognizedShoe, mesh: fem.Mesh, shoe: Shoe, name: str) -> CaseFile:
    """Return the case of a dragged track of a shoe, with a flexible middle shoe."""
    papers = Track.ph4100c()
    y = papers.first_com[1]
    track = papers.with_(
        pitch=recognized.pitch,
        pin_ahead=recognized.pin_ahead,
        pin_height=recognized.pin_height,
        spherical_y=y + recognized.joint_y[0],
        parallel_y=y + recognized.joint_y[1],
    )
    # the weight is the same on tips of grousers as on the plate
    load = GROUND_PRESSURE * track.pitch * float(np.ptp(mesh.nodes[:, 1]))
    flexible = FlexibleShoes.ph4100c(f"{name}.msh.gz").with_(
        shoes=(MIDDLE_SHOE,), pins=COUPLING, density=STEEL_DENSITY, static_fields=_covers_its_rectangle(mesh)
    )
    if "whole top" not in mesh.surfaces:
        flexible = flexible.with_(load_surface="underside")
    case = Case.translation().with_(
        name=name,
        shoe=shoe,
        track=track,
        loads=LoadCycle.constant(float(f"{load:.3g}"), track.shoe_count),
        flexible=flexible,
    )
    return CaseFile(case=case, duration=DURATION)


def _covers_its_rectangle(mesh: fem.Mesh) -> bool:
    """Return True if underside and rails, if any, fill their rectangles without gaps."""
    try:
        return basis.ground_grid(mesh).weights.shape[0] > 0
    except ValueError:
        return False


def _refusals(case: Case, mesh: fem.Mesh) -> Iterator[str]:
    """Yield the reasons for which a run with flexible shoes of a mesh would be refused."""
    name = case.part(FlexibleShoes).mesh
    checks: tuple[Callable[[], object], ...] = (
        lambda: shoe_mesh.pin_interfaces(mesh, name, case.track),
        lambda: shoe_mesh.check_fit(mesh, name, case.shoe, case.shoe.rails),
    )
    for check in checks:
        try:
            check()
        except ValueError as error:
            yield str(error)


def _table(
    recognized: RecognizedShoe,
    mesh: fem.Mesh,
    shoe: Shoe,
    body: fem.ElasticBody,
    frequencies: np.ndarray,
) -> pd.DataFrame:
    """Return the figures of a shoe, one row for each quantity."""
    inertia = body.inertia
    size = np.ptp(mesh.nodes, axis=0)
    rear, front = recognized.axes.pins.lines
    scale = recognized.axes.scale
    of_mesh = quality.mesh_quality(mesh)
    of_modes = ", ".join(f"{value:.4g}" for value in frequencies)
    rows: list[tuple[str, object, str]] = [
        ("unit of the file", recognized.unit, ""),
        ("mass", f"{body.mass:.5g}", "kg"),
        ("COM above the underside", f"{shoe.com_height:.5g}", "m"),
        ("length, width, height", " x ".join(f"{side:.4g}" for side in size), "m"),
        ("inertia xx, yy, zz", ", ".join(f"{moment:.4g}" for moment in np.diag(inertia)), "kg m2"),
        (
            "inertia yz, xz, xy",
            ", ".join(f"{inertia[a, b]:.3g}" for a, b in ((1, 2), (0, 2), (0, 1))),
            "kg m2",
        ),
        ("first free-free frequencies", of_modes, "Hz"),
        ("pitch", f"{1e3 * recognized.pitch:.3f}", "mm"),
        ("pins ahead of and above the COM", f"{recognized.pin_ahead:.5g}, {recognized.pin_height:.5g}", "m"),
        ("joints at y", f"{recognized.joint_y[0]:.5g}, {recognized.joint_y[1]:.5g}", "m"),
    ]
    for end, line in (("front", front), ("rear", rear)):
        radii = [line.radius] if line.has_equal_radii else sorted({bore.radius for bore in line.bores})
        words = " and ".join(dict.fromkeys(f"{1e3 * scale * radius:.3f}" for radius in radii))
        fit = f"{len(line.bores)} of radius {words}"
        rows.append((f"{end} bores", f"{fit}, round within {1e3 * scale * line.off_round:.2g}", "mm"))
    footprint = f"{recognized.surfaces.footprint}, {shoe.ground_area:.4g}"
    rows.append(("underside that presses", footprint, "m2"))
    rows.append(("rails", "two" if "roller path" in mesh.surfaces else "none", ""))
    rows.append(("nodes, elements", f"{len(mesh.nodes)}, {len(mesh.elements)}", ""))
    rows.append(("shape of elements, least and mean", f"{of_mesh.least:.2f}, {of_mesh.mean:.2f}", "of 1"))
    wall = "no wall is a single element thick"
    if of_mesh.thinnest is not None:
        share = 100.0 * of_mesh.thin_share
        wall = f"{1e3 * of_mesh.thinnest:.3g} mm, 1 element thick, as at {share:.0f} % of the surface"
    rows.append(("thinnest wall in elements", wall, ""))
    return pd.DataFrame(rows, columns=["quantity", "value", "unit"])


def shoe_name(path: Path) -> str:
    """Return the name of a maker's file without its endings.

    Raises ValueError if it has nothing before them.
    """
    name = path.name.partition(".")[0]
    if not name:
        raise ValueError(
            f"{path}: the file must have a name before its ending, such as shoe{path.name}, by which mesh "
            "and case are called"
        )
    return name


def paths_of(name: str, folder: Path) -> dict[str, Path]:
    """Return the paths of a shoe's files in a folder: "mesh", "case" and "picture"."""
    endings = {"mesh": "msh.gz", "case": "toml", "picture": "png"}
    return {kind: folder / f"{name}.{ending}" for kind, ending in endings.items()}


def write_shoe(shoe: ShoeFile, folder: str | Path = ".", overwrite: bool = False) -> dict[str, Path]:
    """Write mesh, case file and picture of a shoe into a folder, named after the case.

    Returns
    -------
    dict of str to Path
        "mesh", "case" and "picture".

    Raises
    ------
    FileExistsError
        If one of them exists and `overwrite` is false; then none is written.
    """
    whole = paths_of(shoe.case_file.case.name, files.writable_folder(Path(folder)))
    for path in whole.values():
        files.refuse_existing(path, overwrite)
    _write_mesh(shoe.recognized.mesh, whole["mesh"], overwrite)
    with files.whole_file(whole["case"], overwrite) as temporary:
        temporary.write_text(shoe_text(shoe), encoding="utf-8")
    with style.titled_figure(shoe.case_file.case.name, 9.0, 6.5) as figure:
        draw_recognized(figure, shoe.recognized.mesh)
    style.save_figure(figure, whole["picture"], overwrite)
    return whole


def _write_mesh(mesh: fem.Mesh, path: Path, overwrite: bool) -> None:
    """Write a mesh, whole or not at all."""
    with files.whole_file(path, overwrite) as temporary:
        # the suffix selects the format of a mesh
        packed = temporary.with_name(f"{temporary.name}.msh.gz")
        try:
            fem.write_mesh(packed, mesh)
            packed.replace(temporary)
        finally:
            packed.unlink(missing_ok=True)


def shoe_text(shoe: ShoeFile) -> str:
    """Return the case file of a shoe as TOML, with assumed values marked and open decisions on top."""
    lines = []
    table = ""
    for line in case_text(shoe.case_file, by_hand=True).splitlines():
        if line.startswith("["):
            table = line.strip("[]")
        key = line.partition(" = ")[0]
        is_assumed = " = " in line and f"{table}.{key}" in ASSUMED
        joiner = "; " if " # " in line else " # "
        lines.append(f"{line}{joiner}{MARK}" if is_assumed else line)
    heads = [
        "# [shoe], [track] and the mesh follow from the shape of the shoe; steel's values, the number of"
    ]
    heads.append(f"# shoes and their loads (the papers' ground pressure) do not, and are marked {MARK}.")
    heads += [f"# {line}" for line in shoe.lines()]
    return "\n".join([*heads, *lines]) + "\n"


def datasheet_shoe(
    path: Path, size: str, folder: Path, overwrite: bool = False
) -> tuple[pd.DataFrame, dict[str, Path]]:
    """Write the ready shoe that fits the machine of a case file with a datasheet: mesh, picture and case.

    The case is that of the file with the mesh and a flexible shoe. The files are named after it: NAME_shoe.

    Parameters
    ----------
    path : Path
        Case file with a datasheet.
    size : str
        "coarse", "study" or "fine".
    folder : Path
    overwrite : bool

    Returns
    -------
    table : DataFrame
        Properties of the shoe: quantity, value, unit.
    paths : dict of str to Path
        "mesh", "case" and "picture".

    Raises
    ------
    ValueError
        If the file has no datasheet, or no ready shoe fits it.
    FileExistsError
        If one of the files exists and `overwrite` is false; then none is written.
    """
    case_file = read_case(path, ["datasheet.shoe_mesh='none'"])
    sheet = case_file.datasheet
    if sheet is None:
        raise ValueError(f"{path} must have a table [datasheet], to which the shoe is fitted")
    name = f"{path.stem}_shoe"
    whole = paths_of(name, files.writable_folder(folder))
    for target in whole.values():
        files.refuse_existing(target, overwrite)
    follows = derived(sheet)
    shoe = datasheet_meshes.fitted_shoe(sheet, follows.case.shoe, follows.chain, size)
    _write_mesh(shoe.mesh, whole["mesh"], overwrite)
    with files.whole_file(whole["case"], overwrite) as temporary:
        temporary.write_text(_with_shoe(path, name, whole["mesh"], folder), encoding="utf-8")
    with style.titled_figure(name, 9.0, 6.5) as figure:
        draw_recognized(figure, with_load_surfaces(shoe.mesh))
    style.save_figure(figure, whole["picture"], overwrite)
    body = fem.ElasticBody(shoe.mesh, STEEL)
    rows = [
        ("kind", datasheet_meshes.ready_kind(sheet), ""),
        ("mass", f"{body.mass:.5g}", "kg"),
        ("mass of the datasheet's machine", f"{follows.case.shoe.mass:.5g}", "kg"),
        ("thickness of the plate, which makes the mass", f"{1e3 * shoe.plate_thickness:.3g}", "mm"),
        ("pitch", f"{1e3 * follows.chain.pitch:.3f}", "mm"),
        ("length, width, height", " x ".join(f"{side:.4g}" for side in np.ptp(shoe.mesh.nodes, axis=0)), "m"),
        ("inertia xx, yy, zz", ", ".join(f"{moment:.4g}" for moment in np.diag(body.inertia)), "kg m2"),
        ("nodes, elements", f"{len(shoe.mesh.nodes)}, {len(shoe.mesh.elements)}", ""),
        ("shape of elements, least", f"{quality.mesh_quality(shoe.mesh).least:.2f}", "of 1"),
    ]
    return pd.DataFrame(rows, columns=["quantity", "value", "unit"]), whole


def _with_shoe(path: Path, name: str, mesh: Path, folder: Path) -> str:
    """Return the text of a case file with a mesh of its shoes and a flexible shoe, for a folder."""
    document = tomlkit.parse(path.read_text(encoding="utf-8"))
    document["name"] = name
    table: Any = document["datasheet"]
    table["shoe_mesh"] = mesh.name
    if "flexible" not in document:
        case = read_case(path, [f"datasheet.shoe_mesh={mesh.resolve().as_posix()!r}"]).case
        flexible = tomlkit.table()
        flexible["shoes"] = [passed_shoe(case)]
        flexible["shoes"].comment("below the foremost roller, so that all others pass over it")
        document["flexible"] = flexible
    return tomlkit.dumps(document)
