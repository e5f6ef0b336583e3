"""One check of a shoe into one folder: static cases without a run, their tables and pictures."""

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from exudyn_crawler.case.parameters.checks import out_of_range, warn_of
from exudyn_crawler.files import refuse_existing, writable_folder
from exudyn_crawler.results.checks.cases import ShoeCheck, read_check
from exudyn_crawler.results.checks.solve import CheckedShoe, CheckResults, solve_cases
from exudyn_crawler.results.stress.hot_spots import flat_triangles
from exudyn_crawler.views import style
from exudyn_crawler.views.pages import page
from exudyn_crawler.views.pages.packing import SceneArrays, packed_scene
from exudyn_crawler.views.scenes.pictures import paint
from exudyn_crawler.views.scenes.scene import Colouring, Scene, Solid, View
from exudyn_crawler.views.tables import cell_text, write_table
from fem.stress import von_mises

PEAKS, MOMENTS, CYCLES, HERTZ = "peaks.csv", "moments.csv", "cycles.csv", "hertz.csv"
PICTURES, PAGE = "pictures", "check.html"
BENT = 0.05  # m, at which the greatest elastic displacement is drawn at most
BY_CASE = "Colours are the stress of a case, on a scale of its own."
VIEWS = {"from ahead and above": (25.0, 30.0), "from ahead and below": (25.0, -30.0)}  # azimuth, elevation
WINDOW = (-2.0, 2.0, -0.8, 0.8)  # m


def check_cases(
    check: ShoeCheck | str | Path,
    out: str | Path | None = None,
    *,
    pictures: bool = True,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _text: None,
) -> CheckResults:
    """Check a shoe, or that of a file, by static cases: peaks by region, section moments, cycles to a crack.

    Tables, page and, if asked for, `pictures` of all cases go into the folder `out`, if one is given; `say`
    gets a line on what goes on.

    FileNotFoundError if there is no such file; FileExistsError, before anything is solved, if the folder has
    results and `overwrite` is false; ValueError, naming it, if a case is not in balance or has no support.
    """
    check = check if isinstance(check, ShoeCheck) else read_check(check)
    warn_of(out_of_range(check))
    folder = None if out is None else Path(out)
    if folder is not None:
        for name in (PEAKS, MOMENTS, CYCLES, HERTZ, PAGE):
            refuse_existing(folder / name, overwrite)
    found = solve_cases(check, CheckedShoe.of(check), say)
    if folder is not None:
        writable_folder(folder)
        tables = {PEAKS: found.table, MOMENTS: found.moments, CYCLES: found.cycles, HERTZ: found.hertz}
        for name, table in tables.items():
            write_table(table, folder / name, overwrite)
        write_check_page(found, folder / PAGE, overwrite)
        if pictures:
            say(f"pictures of {len(found.cases)} cases")
            writable_folder(folder / PICTURES)
            for number, case in enumerate(found.cases):
                name = "".join(one if one.isalnum() or one in "-." else "_" for one in case.name)
                style.save_figure(
                    case_figure(found, number), folder / PICTURES / f"{number + 1:03d}_{name}.png", overwrite
                )
    return found


def write_check_page(found: CheckResults, path: Path, overwrite: bool = False) -> Path:
    """Write a page of a check: its cases in 3D, which of them cracks what, and its tables."""
    arrays, mesh, check = SceneArrays(), found.shoe.mesh, found.check
    colourings = []
    for case, stress in zip(found.cases, found.stress, strict=True):
        mises = von_mises(stress) / style.MEGA
        high = style.round_up(float(mises.max()))
        limits: tuple[float, float, str] = (0.0, high, style.STRESS_MAP)
        colourings.append(Colouring("von Mises in MPa", mises[None, None], *limits, name=case.name))
    faces = np.searchsorted(mesh.surface_nodes, flat_triangles(mesh.boundary))
    points, shades = mesh.nodes[mesh.surface_nodes], tuple(colourings)
    solid = Solid("shoe", points, (faces,), "white", colourings=shades, nodes=mesh.surface_nodes)
    scene = packed_scene(Scene(("",), (solid,)), arrays)
    sections = [
        page.Section("check", "Cases in 3D", page.part("coloured", "check", BY_CASE)),
        page.Section("cycles", "Cycles to a crack", page.table(found.worst_cycles)),
        page.Section("moments", "Section moments and blows", page.table(found.moments)),
        page.Section("hertz", "Below a tread", page.table(found.hertz)),
        page.Section("peaks", "Peaks by region", page.table(found.table)),
    ]
    lead = [
        f"{len(found.cases)} static cases, mesh {check.mesh}, {check.material.name}",
        f"an hour: how many crack 2.5 % of the shoes within {cell_text(check.hours)} h; worst regions",
    ]
    data = {"scenes": {"check": {"": scene}}, "arrays": arrays.packed, "first": []}
    return page.write_page(page.page(f"Check of {check.name}", lead, sections, data), path, overwrite)


def case_figure(found: CheckResults, number: int) -> Figure:
    """One case from above and from below: von Mises stress on the bent shoe, and its peaks by region."""
    mesh, case, stress = found.shoe.mesh, found.cases[number], von_mises(found.stress[number])
    bend = found.displacement[number]
    larger, high = style.drawn_scale(bend, BENT), style.round_up(float(stress.max()) / style.MEGA)
    faces = np.searchsorted(mesh.surface_nodes, flat_triangles(mesh.boundary))
    colouring = Colouring("von Mises stress in MPa", stress / style.MEGA, 0.0, high, style.STRESS_MAP)
    points = mesh.nodes[mesh.surface_nodes] + larger * bend
    solid = Solid(case.name, points, (faces,), "white", colourings=(colouring,))
    with mpl.rc_context(style.STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(9.0, 7.4))
        axes = figure.subplots(len(VIEWS), 1)
        for ax, (title, (azimuth, elevation)) in zip(axes, VIEWS.items(), strict=True):
            view = View.seen_from(azimuth, elevation)
            paint(ax, [solid], view, WINDOW)
            ax.set_title(title, loc="left")
            ax.set_axis_off()
        own = found.table[found.table["case"] == case.name]
        peaks = ", ".join(f"{a} {b:.0f}" for a, b in zip(own["region"], own["von Mises in MPa"], strict=True))
        figure.suptitle(f"{case.name}\n{peaks} MPa; displacement x {larger:g}", parse_math=False)
        figure.colorbar(style.scale_of(0.0, high, style.STRESS_MAP), ax=axes, label=colouring.title)
    return figure
