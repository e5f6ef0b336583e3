"""A user's script, checked by `mypy --strict` in a folder of its own (`test_public_names.py`); never run."""

from pathlib import Path
from typing import assert_type

import xarray as xr

import fem
import meshes
from exudyn_crawler import (
    Case,
    CaseFile,
    CrawlerError,
    Drive,
    Duty,
    History,
    LoadCycle,
    Phase,
    SphereContact,
    StepProfile,
    WearPlan,
    add_track,
    assess,
    check_cases,
    dynamic_settings,
    life,
    read_case,
    read_duty,
    read_wear,
    recover_stresses,
    restore_state,
    run_case,
    simulate,
    solve_dynamic,
    store_state,
    wear,
    write_animation,
    write_case,
    write_report,
)


def changed(path: Path) -> Case:
    """Return the case of a file with other ground, drive, loads and contact."""
    case = read_case(path).case
    assert_type(case, Case)
    even = tuple([386e3] * case.track.shoe_count)
    cycle = LoadCycle(phases=(Phase(name="propel", end=3.0, loads=even),))
    drive = Drive(speed=StepProfile(times=(0, 2), values=(0, 0.2)), on=((0, 3),))
    ground = case.terrain.with_(spring_stiffness=10e6)
    return case.with_(terrain=ground, drive=drive, loads=cycle, contact=SphereContact.oil_sand())


def looked_at(history: History, folder: Path) -> float:
    """Write a history and return a number of it."""
    assert_type(history.position, xr.DataArray)
    assert_type(history.quantity("joint_force"), xr.DataArray)
    assert_type(History.load(history.save(folder / "history.nc")), History)
    write_animation(history, folder / "track.mp4", end=0.5)
    assert_type(write_report(folder), Path)
    return history.duration + float(history.position.sel(shoe=13, axis="x").max())


def run(folder: Path) -> None:
    """Run a case into a folder, and the machine hours and percent worn that follow."""
    try:
        done = run_case(CaseFile(case=changed(folder / "my.toml"), duration=0.5), folder, say=print)
    except CrawlerError as error:
        print(error)
        return
    looked_at(done.history, folder)
    print(done.recovered().hot_spots[13]["von_mises"].max(), recover_stresses(done.history).hot_spots)
    write_case(CaseFile(case=Case.stress("coarse")), folder / "other.toml")
    assert_type(read_duty(folder / "duty.toml"), Duty)
    assert_type(read_wear(folder / "wear.toml"), WearPlan)
    lives = life(folder / "duty.toml", folder / "life")
    print(lives.table, lives.causes(), wear(folder / "wear.toml").work)
    print(check_cases(folder / "shoe.toml", pictures=False).table, assess(Case.shovel(), run=folder).items)


def coupled() -> None:
    """Put a user's model on a machine's tracks, and go back to a stored state."""
    import exudyn

    mbs = exudyn.SystemContainer().AddSystem()
    case = Case.rolled()
    track = add_track(mbs, case, carried_mass=16e3, carried_com=(0.0, 0.0, 1.0))
    track.set_speeds([0.5, 0.5])
    assert_type(track.add_sensor("link_tension", joint=5), int)
    mbs.Assemble()
    state = store_state(mbs)
    solve_dynamic(mbs, dynamic_settings(case, 0.1))
    restore_state(mbs, state)
    assert_type(track.history, History)


def elements() -> None:
    """Reduce a shoe without a track."""
    mesh = meshes.shoe_mesh("coarse")
    assert_type(mesh, fem.Mesh)
    body = fem.ElasticBody(mesh, meshes.STEEL)
    bores = meshes.joint_interfaces(mesh)
    reduced = fem.craig_bampton(body, bores, 10, partition=fem.Partition(body, bores))
    assert_type(reduced, fem.ReducedBody)
    print(reduced.frequencies, body.mass)


if __name__ == "__main__":
    looked_at(simulate(Case.translation(), duration=0.01), Path("results"))
