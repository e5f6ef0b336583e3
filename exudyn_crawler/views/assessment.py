"""Drawings of an assessment: pressure and stability over the slewing angle, rollers, travel, utilisation."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from exudyn_crawler.assessment import forces, pressure, slewing, travel
from exudyn_crawler.assessment.assessment import Assessment
from exudyn_crawler.assessment.items import NOT_KNOWN
from exudyn_crawler.views import style

WITHIN, EXCEEDS, LIMIT, UNKNOWN = "#4f8a5b", "#c0271d", "#3c4a54", "#9aa3a9"
COLOURS = {"yes": WITHIN, "no": EXCEEDS}
GRADES = np.linspace(0.0, 0.5, 51)
"""Grades (rise over run) at which travel is drawn."""


def file_name(drawing: str) -> str:
    """Return the name of the file of a drawing."""
    return f"{drawing.replace(' ', '_')}.png"


def assessment_figures(found: Assessment) -> dict[str, Figure]:
    """Return all drawings of an assessment by name."""
    return {
        "utilisation": utilisation_figure(found),
        "ground pressure over slew": pressure_figure(found),
        "pressure along the tracks": tracks_figure(found),
        "stability over slew": stability_figure(found),
        "travel": travel_figure(found),
        "roller loads": rollers_figure(found),
        "chain tension": chain_figure(found),
    }


def utilisation_figure(found: Assessment) -> Figure:
    """Draw the utilisation of all items with a limit as bars, the greatest on top."""
    items = [item for item in found.governing if np.isfinite(item.utilisation)][::-1]
    with style.titled_figure(
        "Utilisation, by the load case that governs", 9.0, 0.8 + 0.27 * len(items)
    ) as figure:
        ax = figure.subplots()
        used = [item.utilisation for item in items]
        colours = [COLOURS.get(item.verdict, UNKNOWN) for item in items]
        ax.barh([item.item for item in items], used, color=colours)
        ax.axvline(1.0, color=LIMIT, lw=1.2)
        for place, item in enumerate(items):
            ax.text(
                item.utilisation,
                place,
                f" {item.utilisation:.2f}  {item.load_case}{f', {NOT_KNOWN}' if item.needs else ''}",
                va="center",
                fontsize=7,
            )
        ax.set_xlim(0.0, 1.45 * max([*used, 1.0]))
        ax.set_xlabel("utilisation: number x factor / limit")
    return figure


def pressure_figure(found: Assessment) -> Figure:
    """Draw the greatest ground pressure over the slewing angle, in polar form, beside the allowed one."""
    with style.titled_figure("Greatest ground pressure over the angle of slewing, kPa", 6.4, 5.6) as figure:
        ax = _polar(figure)
        allowed = found.numbers.ground.allowed / 1e3
        for state, rows in found.over_slew.groupby("state", sort=False):
            angle = np.radians(rows["slew in deg"].to_numpy())
            greater = np.fmax(
                rows["left track, greatest in kPa"], rows["right track, greatest in kPa"]
            ).to_numpy()
            greater = np.where(np.isfinite(greater), greater, np.nan)
            mean = np.fmax(rows["left track, mean in kPa"], rows["right track, mean in kPa"]).to_numpy()
            (line,) = ax.plot(*_closed(angle, greater), label=f"{state}, greatest", lw=1.5)
            mean = np.where(np.isfinite(mean), mean, np.nan)
            ax.plot(
                *_closed(angle, mean), "--", color=line.get_color(), label=f"{state}, mean of the same track"
            )
        if np.isfinite(allowed):
            ax.plot(np.linspace(0.0, 2.0 * np.pi, 181), np.full(181, allowed), color=EXCEEDS, label="allowed")
        ax.set_ylim(0.0, None)
        ax.legend(loc="upper left", bbox_to_anchor=(-0.2, -0.08), ncols=2, fontsize=8)
    return figure


def _polar(figure: Figure, place: tuple[int, int, int] = (1, 1, 1)) -> Any:
    """Return polar axes with straight ahead on top and the left side on the left."""
    ax: Any = figure.add_subplot(*place, projection="polar")
    ax.set_theta_zero_location("N")
    ax.set_theta_direction(1)
    ax.set_thetagrids(
        range(0, 360, 30),
        ["ahead", "30", "60", "left", "120", "150", "astern", "210", "240", "right", "300", "330"],
    )
    return ax


def _closed(angle: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a curve closed by its first point."""
    return np.append(angle, angle[0]), np.append(values, values[0])


def tracks_figure(found: Assessment) -> Figure:
    """Draw the pressure along both tracks, with the rollers, at the slewing angle of greatest pressure.

    Each track is a beam on the ground.
    """
    over = found.over_slew
    last = over[over["state"] == over["state"].iloc[-1]].reset_index(drop=True)
    greater = np.fmax(last["left track, greatest in kPa"], last["right track, greatest in kPa"])
    greater = greater.where(np.isfinite(greater), -1.0)
    row = last.iloc[int(greater.argmax())]
    numbers = found.numbers
    payload = 0.0 if row["state"] == slewing.WITHOUT else numbers.work.payload
    work = numbers.empty._replace(payload=payload)
    level = forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)
    acting = forces.forces_at(numbers.weights, work, np.radians([row["slew in deg"]]), level)
    stands = forces.resultant(acting)
    loads = pressure.track_loads(stands.weight, stands.aside, numbers.fewest.gauge)
    title = f"Pressure along the tracks, upper structure at {row['slew in deg']:.0f} deg, {row['state']}"
    with style.titled_figure(title, 9.0, 3.6) as figure:
        ax = figure.subplots()
        half = 0.5 * numbers.fewest.length
        for name, load in zip(("left", "right"), loads, strict=True):
            line = _line(float(load[0]), float(stands.ahead[0]), numbers.fewest)
            places = np.linspace(-half, half, 200)
            ax.plot(places, line(places) / 1e3, label=f"{name} track, {load[0] / 1e6:.3g} MN")
        if np.isfinite(numbers.ground.allowed):
            ax.axhline(numbers.ground.allowed / 1e3, color=EXCEEDS, label="allowed")
        ax.plot(
            numbers.rollers.places,
            np.zeros(len(numbers.rollers.places)),
            "o",
            color=style.ROLLER,
            label="rollers",
        )
        ax.axvline(float(stands.ahead[0]), color=LIMIT, lw=0.8, ls=":", label="resultant")
        ax.set_xlabel("position from the middle in m, forward positive")
        ax.set_ylabel("kPa")
        ax.set_ylim(0.0, None)
        ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _line(load: float, ahead: float, area: pressure.Footprints) -> Callable[[np.ndarray], np.ndarray]:
    """Return the pressure (Pa) along a track as a function of position (m)."""
    shape = pressure.track_pressure(load, ahead, area.length, area.width)
    end = np.copysign(1.0, ahead) * 0.5 * area.length
    fall = (shape.greatest - shape.least) / shape.length
    return lambda x: np.maximum(shape.greatest - fall * np.abs(end - x), 0.0)


def stability_figure(found: Assessment) -> Figure:
    """Draw the tipping angle over the slewing angle, and the rated load at the given reach, in polar form."""
    with style.titled_figure("Stability over the angle of slewing, on the level", 10.0, 5.2) as figure:
        rated = "rated load in t" in found.over_slew
        left = _polar(figure, (1, 1 + rated, 1))
        for state, rows in found.over_slew.groupby("state", sort=False):
            angle = np.radians(rows["slew in deg"].to_numpy())
            tilt = rows["tips at in deg"].to_numpy()
            left.plot(*_closed(angle, tilt), label=f"{state}: tips at, deg")
        slopes = np.degrees([found.numbers.slope, found.numbers.grade])
        for words, slope in zip(("side slope", "grade"), slopes, strict=True):
            left.plot(
                np.linspace(0, 2 * np.pi, 181),
                np.full(181, slope),
                ls="--",
                lw=0.9,
                label=f"permitted {words}",
            )
        if rated:
            _draw_rated_load(_polar(figure, (1, 2, 2)), found)
        for ax in figure.axes:
            ax.set_ylim(0.0, None)
            ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), fontsize=8)
    return figure


def _draw_rated_load(ax: Any, found: Assessment) -> None:
    """Draw the rated load at the given reach over the slewing angle, and the payload."""
    rows = found.over_slew[found.over_slew["state"] == slewing.WITHOUT]
    angle = np.radians(rows["slew in deg"].to_numpy())
    rated = rows["rated load in t"].to_numpy()
    ax.plot(
        *_closed(angle, np.where(np.isfinite(rated), rated, np.nan)),
        color=style.TUMBLER,
        label=f"{found.settings.rated_part:g} of the tipping load at {found.numbers.work.reach:.3g} m, t",
    )
    if payload := found.numbers.work.payload:
        around = np.linspace(0.0, 2.0 * np.pi, 181)
        ax.plot(around, np.full(181, payload / 1e3), color=EXCEEDS, label="payload, t")


def travel_figure(found: Assessment) -> Figure:
    """Draw the pull of both tracks over the grade beside drive and ground, and the pull of turns."""
    numbers = found.numbers
    weight = numbers.weight
    ground = numbers.ground
    slopes = np.arctan(GRADES)
    needed = numbers.resistance.on_grade(weight, slopes)
    held = [
        travel.traction(weight * np.cos(slope), ground.friction, ground.cohesion, numbers.footprints.area)
        for slope in slopes
    ]
    with style.titled_figure("Travel: pull of both tracks", 9.0, 3.6) as figure:
        ax, bars = figure.subplots(1, 2, width_ratios=(2, 1))
        ax.plot(100.0 * GRADES, np.array(needed) / 1e6, label="required: grade and resistance")
        ax.plot(100.0 * GRADES, np.array(held) / 1e6, label="traction limit")
        ax.axhline(2.0 * numbers.drive.pull / 1e6, color=style.TUMBLER, label="drive pull")
        ax.axvline(100.0 * np.tan(numbers.grade), color=LIMIT, ls=":", label="permitted grade")
        ax.set_xlabel("grade in %")
        ax.set_ylabel("MN")
        ax.set_ylim(0.0, None)
        ax.legend(fontsize=8)
        rows = [row for row in found.loads if row.drive in ("straight", "turn")]
        names = [row.name.replace("travels ", "").replace(" on the level", "") for row in rows]
        bars.barh(names[::-1], [row.needed / 1e6 for row in rows[::-1]], color=style.ROLLER)
        bars.axvline(numbers.drive.pull / 1e6, color=style.TUMBLER, label="drive")
        bars.set_xlabel("pull of a track in MN")
        bars.legend(fontsize=8)
    return figure


def rollers_figure(found: Assessment) -> Figure:
    """Draw the roller loads of the more loaded track in each load case."""
    places = found.numbers.rollers.places
    rows = found.loads
    with style.titled_figure("Roller loads of the more loaded track, kN", 9.0, 4.2) as figure:
        ax = figure.subplots()
        table = np.array([row.roller_loads for row in rows]) / 1e3
        image = ax.imshow(table, aspect="auto", cmap=style.STRESS_MAP)
        ax.set_yticks(range(len(rows)), [f"{row.name} ({row.group})" for row in rows], fontsize=8)
        ax.set_xticks(range(len(places)), [f"{place:.2f}" for place in places])
        ax.set_xlabel("roller position from the middle in m, forward positive")
        ax.grid(visible=False)
        most = table.max()
        for line, values in enumerate(table):
            for column, value in enumerate(values):
                colour = "white" if value > 0.6 * most else "black"
                ax.text(column, line, f"{value:.0f}", ha="center", va="center", fontsize=7, color=colour)
        figure.colorbar(image, ax=ax, label="kN")
    return figure


def chain_figure(found: Assessment) -> Figure:
    """Draw the chain tension of each load case: pretension and the part of the pull."""
    rows = found.loads[::-1]
    rest = found.numbers.chain.rest / 1e6
    with style.titled_figure("Chain tension: at rest (pretension) and pull", 9.0, 3.8) as figure:
        ax = figure.subplots()
        names = [f"{row.name} ({row.group})" for row in rows]
        ax.barh(names, [rest] * len(rows), color=style.ROLLER, label="at rest")
        ax.barh(
            names,
            [max(row.tension / 1e6 - rest, 0.0) for row in rows],
            left=rest,
            color=style.TUMBLER,
            label="by the pull",
        )
        ax.set_xlabel("MN")
        ax.legend(fontsize=8, loc="upper right")
    return figure
