"""Life of the roller path in rolling propel by the shoe's top plate and the ground's stiffness.

No paper reports this study. One flexible shoe stands under the middle of the machine. At full speed the
machine rolls on by the distance of two rollers; all hours are hours of such propel.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from exudyn_crawler import Case, CaseFile, FatigueMaterial, FlexibleShoes, Shoe
from exudyn_crawler.case import Rolled
from exudyn_crawler.sweep.answers import Answer, Life
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.results import SweepRun
from exudyn_crawler.sweep.running import run_sweep
from exudyn_crawler.sweep.vary import Vary
from exudyn_crawler.views.style import STYLE, save_figure
from fem import write_mesh
from meshes import ShoeDimensions, mesh_shoe

THICKNESSES = (0.030, ShoeDimensions.top_thickness, 0.054)  # m, thicknesses of the top plate
STIFFNESSES = (10e6, 20e6, 40e6)  # N/m, stiffnesses of the ground's springs; the middle one is the papers'
FLEXIBLE = 11
SIZE = "coarse"
OUTPUT_INTERVAL = 0.02
"""Time between stored states, s; the machine rolls by 2 mm."""
PICTURE = "lives.png"
MILLI = 1e-3
MEGA = 1e6
VARIED = ("flexible.mesh", "shoe.mass", "shoe.inertia", "shoe.load_point")
"""Parameters that vary with the thickness: rigid shoes weigh as much as the flexible one."""


def plate_meshes(folder: Path, thicknesses: Sequence[float], say: Callable[[str], None]) -> dict[float, Path]:
    """Return mesh files in a folder of shoes with these top plates (m); mesh those that are missing."""
    paths = {}
    for thickness in thicknesses:
        path = folder / f"shoe_{SIZE}_top_{1e3 * thickness:g}mm.msh.gz"
        if not path.is_file():
            say(f"meshing a shoe with a top plate of {1e3 * thickness:g} mm")
            mesh = mesh_shoe(ShoeDimensions(top_thickness=thickness), SIZE)
            folder.mkdir(parents=True, exist_ok=True)
            write_mesh(path, mesh)
        paths[thickness] = path.resolve()
    return paths


def passing_case(mesh: str = SIZE) -> CaseFile:
    """Return a machine at speed that rolls over one flexible shoe by the distance of two rollers."""
    case = Case.rolled()
    rollers = Rolled.ph4100c().rollers
    speed = case.drive.speed
    case = case.with_(
        name="plate",
        flexible=FlexibleShoes.ph4100c(mesh).with_(shoes=(FLEXIBLE,)),
        solver=case.solver.with_(output_interval=OUTPUT_INTERVAL),
    )
    duration = speed.times[-1] + (rollers[1] - rollers[0]) / speed.values[-1]
    return CaseFile(case=case, duration=duration)


def plate_sweep(
    meshes: Mapping[float, Path], stiffnesses: Sequence[float] = STIFFNESSES, case: CaseFile | None = None
) -> Sweep:
    """Return the sweep of `passing_case` over top plates (m), by meshes, and ground stiffness (N/m)."""
    base = case or passing_case()
    shoes = {path: Shoe.from_mesh(str(path)) for path in meshes.values()}
    begin = base.case.drive.speed.times[-1]
    # the signed von Mises stress jumps about the bores, where the shear of the pins changes the sign
    life = Life(
        name="life_of_shoe", material=FatigueMaterial.cast_nicrmo(), criterion="signed principal", begin=begin
    )
    stands_for = tuple((str(path), shoe.mass, shoe.inertia, shoe.load_point) for path, shoe in shoes.items())
    top_plate = Vary(key=VARIED, name="top_plate", unit="m", values=tuple(meshes), settings=stands_for)
    springs = Vary(key="terrain.spring_stiffness", unit="N/m", values=tuple(stiffnesses))
    return Sweep(
        case=base,
        vary=(top_plate, springs),
        answers=(
            life.with_(name="life_of_roller_path", region="roller path"),
            life,
            Answer(name="highest_stress", quantity="highest_von_mises", start=begin),
            Answer(name="peak_pin_force", quantity="pin_force", start=begin),
        ),
    )


def draw_lives(ax: Axes, lives: xr.DataArray) -> Axes:
    """Draw lives in hours over the stiffness of springs, a curve for each top plate."""
    for curve in lives.transpose("top_plate", "spring_stiffness"):
        ax.loglog(
            curve.spring_stiffness / MEGA,
            curve,
            "o-",
            label=f"top plate {float(curve.top_plate) / MILLI:g} mm",
        )
    ax.set_xlabel("stiffness of the ground's springs in MN/m")
    ax.set_ylabel("hours of propel that 97.5 % survive")
    ax.set_title(str(lives.name).replace("_", " "))
    stiffnesses = lives.spring_stiffness.values / MEGA
    ax.set_xticks(stiffnesses, [f"{stiffness:g}" for stiffness in stiffnesses])
    ax.xaxis.minorticks_off()
    return ax


def lives_figure(dataset: xr.Dataset) -> Figure:
    """Draw the lives of the roller path and of the whole shoe side by side."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.6))
        left, right = figure.subplots(1, 2)
        draw_lives(left, dataset["life_of_roller_path"])
        draw_lives(right, dataset["life_of_shoe"]).legend()
    return figure


def study(
    out: Path, *, workers: int | None = None, say: Callable[[str], None] = lambda _text: None
) -> SweepRun:
    """Run the sweep's missing runs, and draw lives; errors are those of `plate_meshes` and `run_sweep`."""
    meshes = plate_meshes(out / "meshes", THICKNESSES, say)
    run = run_sweep(plate_sweep(meshes), out, workers=workers, say=say)
    run.check_answers()
    save_figure(lives_figure(run.dataset), out / PICTURE, overwrite=True)
    return run
