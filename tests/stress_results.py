"""Results of a stress study in its own form, from short real runs."""

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler import Case, CrawlerModel, Drive, FlexibleShoes, History, LoadCycle, StepProfile, Terrain
from exudyn_crawler.floating_frame import floating_shoe
from exudyn_crawler.shoe_stress import stress_basis, whole_coordinates
from fem import hot_spots


def short_run(
    duration: float, shoes: tuple[int, ...] = (7, 13), mesh: str = "coarse", top_speed: float = 0.05
) -> History:
    """Track of the stress study with some flexible shoes, set going within half the run."""
    case = Case.translation().with_(
        name="stress",
        terrain=Terrain.stress(),
        drive=Drive(speed=StepProfile(times=(0.0, 0.5 * duration), values=(0.0, top_speed))),
        loads=LoadCycle.propel(),
        flexible=FlexibleShoes.ph4100c(mesh).with_(shoes=shoes),
    )
    return CrawlerModel(case).simulate(duration)


def stress_results(history: History, frames: list[float]) -> tuple[xr.Dataset, dict[int, pd.DataFrame]]:
    """Stress dataset of a history and the tables of hot spots by shoe."""
    case = history.case
    assert case.flexible is not None
    shoes = case.flexible.shoes
    basis = stress_basis(history, floating_shoe(case.flexible, tuple(case.shoe.footprint.tolist())))
    body = basis.whole
    at = [int(np.abs(history.time.values - frame).argmin()) for frame in frames]
    by_shoe, tables = [], {}
    for shoe in shoes:
        q = whole_coordinates(history, basis, shoe)
        stress = body.von_mises(q)
        tables[shoe] = hot_spots(body, history.time.values, q, 5, separation="radius")
        by_shoe.append(
            xr.Dataset(
                {
                    "highest_von_mises": ("time", stress.max(axis=1)),
                    "highest_node": ("time", stress.argmax(axis=1)),
                    "peak_von_mises": ("node", stress.max(axis=0)),
                    "peak_time": ("node", history.time.values[stress.argmax(axis=0)]),
                    "least_von_mises": ("node", stress.min(axis=0)),
                    "frame_von_mises": (("frame", "node"), stress[at]),
                    "frame_displacement": (("frame", "node", "axis"), body.displacement(q[at])),
                }
            )
        )
    dataset = xr.concat(by_shoe, dim="shoe").assign(
        node_position=(("node", "axis"), body.nodes),
        triangle=(("face", "corner"), body.mesh.boundary[:, :3]),
    )
    return (
        dataset.assign_coords(
            shoe=list(shoes),
            node=np.arange(len(body.nodes)),
            time=history.time.values,
            frame=history.time.values[at],
            axis=["x", "y", "z"],
        ),
        tables,
    )
