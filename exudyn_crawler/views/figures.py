"""Time histories of a run as figures: series in units for reading, panels of curves, figures of the papers.

Panels stand one below the other, with the phases of the run as light bands behind the curves. The names of
figures are valid file names.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import matplotlib as mpl
import pandas as pd
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from exudyn_crawler.results import drive_work
from exudyn_crawler.results.checks import roller_path
from exudyn_crawler.results.history import History, RunPhase, common_phases, summary
from exudyn_crawler.results.history.catalogue import QUANTITIES, Quantity, for_reading, link_name, select
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes.gear import each_track

PANEL_WIDTH, PANEL_HEIGHT, TITLE_HEIGHT, TIME_HEIGHT, LABEL_WIDTH = 8.0, 2.2, 0.38, 0.72, 1.1
"""Sizes in inches: width of a figure, height of a panel, of the text above and below the panels, and width of
the labels at their left."""
NAME_SIZE, NAME_INSET = 6.5, 2.0
"""Points: size of a phase's name, and its offset to the right of the band's begin and above the axes."""
SHOES, JOINTS = (1, 4, 7, 10, 13), (1, 4, 7, 10, 12)
"""Shoes that the papers draw, and their links by the rear shoe: the links behind these shoes, and link
12-13."""
GROUPS = (
    *("stress", "motion", "contact", "rollers", "wheels"),
    *("teeth", "tumbler", "side frame", "links", "track"),
)
"""Groups of curves in the order in which a page offers them."""
LABEL = {name: quantity.label for name, quantity in QUANTITIES.items()}
KINEMATICS = {name.replace("_", " "): quantity.label for name, quantity in select(curves="motion").items()}
"""Figures of kinematic quantities in the papers, and the labels of these quantities."""
VECTORS = select(curves="contact", curve_axes=False, dimensions="axis")
CONTACT_VECTORS = [quantity.label for quantity in VECTORS.values()]
SCALARS = select(curves="contact", dimensions="contact")
CONTACT_SCALARS = [quantity.label for quantity in SCALARS.values() if quantity.label not in CONTACT_VECTORS]
JOINT_VECTORS = [
    quantity.label for quantity in select(curves="links", per="link").values() if not quantity.needs
]
"""Labels of forces and sinkage of shoes, and of forces of links."""
OF_RUNS = {name: [label] for name, label in KINEMATICS.items()}
OF_RUNS |= {label: [label] for label in CONTACT_VECTORS} | {"sinkage and friction torque": CONTACT_SCALARS}
OF_RUNS |= {label: [label] for label in JOINT_VECTORS}
OF_RUNS |= {LABEL[name]: [LABEL[name]] for name in ("link_tension", "tooth_force", "wheel_load")}
OF_RUNS |= {"drive torque": [LABEL["drive_moment"], LABEL["tumbler_speed"]]}
OF_RUNS |= {"terrain deformation": [LABEL["terrain_deformation"]]}
"""Figures of every run that has their quantities, and the labels of these quantities."""
SHORT = {LABEL["terrain_deformation"]: "deformation"}  # labels that fit beside a panel
DEPTH_ON_CELLS = "sinkage"  # label of the shoes' depth on cells, which have no heave
ON_RAILS = f"{LABEL['roller_force']} on the {{}} rails"  # label of the force on one rail
OF_FLEXIBLE_SHOES = ("displacement", "velocity", "angular velocity", "contact force")
"""Figures of the flexible shoes."""
OF_PINS = {"revolute joint reaction": "pin force", "revolute joint torque": "pin torque"}
"""Figures of the pins, one for each side."""
ROLLER_PATH = "roller_path"  # name of its table and its figure
DRIVE_WORK = "drive_work"  # the same
MODES_DRAWN = 6  # lowest modal coordinates in the figure
TURNS = {"x": "roll", "y": "pitch", "z": "yaw"}  # components of angles for reading


@dataclass(frozen=True)
class Panel:
    """Axes of a figure over time: label, unit, and series (time,) by name."""

    label: str
    unit: str
    curves: Mapping[str, xr.DataArray]

    def draw(self, ax: mpl.axes.Axes) -> None:
        """Draw the curves over time."""
        for name, values in self.curves.items():
            ax.plot(values.time, values, label=name)
        ax.set_ylabel(f"{self.label}\nin {self.unit}")
        floor = style.negligible(self.unit)
        (low, high) = ax.get_ylim()
        if high - low < 2.0 * floor:
            ax.set_ylim(-floor, floor)


def panel_figure(title: str, panels: Sequence[Panel], phases: Sequence[RunPhase] = ()) -> Figure:
    """Draw panels one below the other with one legend; bands behind the curves show the phases."""
    # an automatic layout would take half of the time of a figure
    with mpl.rc_context(style.STYLE | {"figure.constrained_layout.use": False}):
        height = TITLE_HEIGHT + PANEL_HEIGHT * len(panels) + TIME_HEIGHT
        figure = Figure(figsize=(PANEL_WIDTH, height))
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0].tolist()
        top = 1.0 - TITLE_HEIGHT / height
        bottom = TIME_HEIGHT / height
        figure.subplots_adjust(LABEL_WIDTH / PANEL_WIDTH, bottom, 0.985, top, hspace=0.12)
        for ax, panel in zip(axes, panels, strict=True):
            panel.draw(ax)
        draw_phases(axes, phases)
        axes[-1].set_xlabel("time in s")
        # the name of a case may look like a formula
        figure.suptitle(title, x=0.01, y=1.0 - 0.06 / height, ha="left", parse_math=False)
        figure.align_ylabels(axes)
        handles, labels = axes[0].get_legend_handles_labels()
        if len(labels) > 1:
            close = {"columnspacing": 1.2, "handlelength": 1.4}
            figure.legend(handles, labels, loc="lower center", ncols=len(labels), **close)
    return figure


def draw_phases(axes: Sequence[mpl.axes.Axes], phases: Sequence[RunPhase]) -> None:
    """Draw a band for each phase behind the curves of panels over time (s).

    The panels must have their final position and limits. Colours alternate. Names stand above the first panel
    alone, where no curve can be; a name wider than its band is left out. A run of one phase has no bands.
    """
    # without a given renderer, each text would make its own to find its extent
    figure: Any = axes[0].figure
    renderer = FigureCanvasAgg(figure).get_renderer()
    for panel, ax in enumerate(axes):
        low, high = ax.get_xlim()
        for number, phase in enumerate(phases if len(phases) > 1 else ()):
            begin = max(phase.begin, low)
            end = min(phase.end, high)
            if begin >= end:
                continue
            text = _band(ax, number, begin, end, phase.name)
            if panel > 0 or text.get_window_extent(renderer).x1 > ax.transData.transform((end, 0.0))[0]:
                text.remove()


def _band(ax: mpl.axes.Axes, number: int, begin: float, end: float, name: str) -> mpl.text.Annotation:
    """Draw a band behind the curves, with the colour of its number, and return its name above the axes."""
    colour = style.PHASE_BANDS[number % len(style.PHASE_BANDS)]
    ax.axvspan(begin, end, facecolor=colour, edgecolor="none", zorder=0.0)
    place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
    # the name of a phase may look like a formula
    look: dict[str, Any] = {"fontsize": NAME_SIZE, "color": style.PHASE_NAME, "parse_math": False}
    return ax.annotate(name, (begin, 1.0), xytext=(NAME_INSET, NAME_INSET), va="bottom", **place, **look)


@dataclass(frozen=True)
class Series:
    """Quantity over time: `values` by time, item (such as "shoe 7") and axis, which may be ""."""

    group: str
    label: str
    unit: str
    values: xr.DataArray

    @property
    def items(self) -> list[str]:
        """Names of the items."""
        return self.values["item"].values.tolist()

    def panels(self, items: Sequence[str] | None = None) -> list[Panel]:
        """Return a panel for each axis, with a curve for each of the given items or of all."""
        return overlay({"": self}, self.items if items is None else items)


def history_series(history: History, stress: xr.Dataset | None = None) -> dict[str, Series]:
    """Return all time series of a history and its stresses, by the label of the catalogue."""
    rows = [
        quantity
        for group in GROUPS
        for quantity in select(curves=group).values()
        if history.has(quantity.name, stress)
    ]
    values = history.over_time([quantity.name for quantity in rows], stress)
    by_label = {
        series.label: series for quantity in rows for series in _series(quantity, values[quantity.name])
    }
    if not history.has("unit_heave"):
        depth = LABEL["penetration"]
        by_label[depth] = replace(by_label[depth], label=DEPTH_ON_CELLS)
    return by_label


def overlay(by_label: Mapping[str, Series], items: Sequence[str]) -> list[Panel]:
    """Return a panel for each axis of one quantity of several runs, with a curve for each item.

    The names of curves tell only what differs: the item, the run, or both.
    """
    first = next(iter(by_label.values()))
    is_named = len(items) > 1 or len(by_label) == 1

    def curves(axis: str) -> dict[str, xr.DataArray]:
        return {
            ", ".join(filter(None, (item if is_named else "", run))): series.values.sel(item=item, axis=axis)
            for item in items
            for run, series in by_label.items()
        }

    axes = first.values.axis.values
    return [Panel(f"{axis} {first.label}".strip(), first.unit, curves(axis)) for axis in axes]


def _series(quantity: Quantity, values: xr.DataArray) -> Iterator[Series]:
    """Yield the series of a quantity; forces on rails as the sum of both sides and for each side."""
    values = for_reading(values)
    unit = values.attrs["units"]
    axes = list(quantity.curve_axes)
    if axes:
        # the friction torque acts about the normal: z, apart from the units' tilt
        values = values.sel(axis=axes if len(axes) > 1 else axes[0], drop=True)
    if quantity.name.endswith("angles"):
        values = values.assign_coords(axis=[TURNS[str(axis)] for axis in values.axis.values])
    parts = {quantity.label: values}
    if "rail" in values.dims:
        sides = {ON_RAILS.format(side): values.sel(rail=side, drop=True) for side in values.rail.values}
        parts = {quantity.label: values.sum("rail")} | sides
    if "pin" in values.dims:
        # a rigid link has one joint for both pins, with the link's force
        apart = values.isel(joint=values.isel(time=0).notnull().all(("pin", "axis")).values)
        parts = {quantity.label: apart.stack(place=("joint", "pin"))} if apart.sizes["joint"] else {}
    for label, part in parts.items():
        yield Series(quantity.curves, label, unit, _by_item(part, quantity.per))


def _by_item(values: xr.DataArray, per: str) -> xr.DataArray:
    """Return values with dimensions (time, item, axis); items are named, or are the quantity's only body."""
    if "axis" not in values.dims:
        values = values.expand_dims({"axis": [""]})
    dim = next((str(key) for key in (*NAMED, *values.dims) if key in {*values.dims} - {"time", "axis"}), None)
    if dim is None:
        values = values.expand_dims({"item": [per]})
    else:
        name_of = NAMED.get(dim, lambda _, name: str(name))
        names = [name_of(values, place) for place in values[dim].values]
        dropped = {"place", "joint", "pin", dim} & set(values.coords)
        values = values.drop_vars(dropped).rename({dim: "item"}).assign_coords(item=names)
    return values.transpose("time", "item", "axis")


NAMED: dict[str, Callable[[xr.DataArray, Any], str]] = {
    "shoe": lambda _, shoe: f"shoe {shoe}",
    "joint": lambda values, joint: link_name(values.joint, joint),
    "roller": lambda _, roller: f"roller {roller}",
    "track": lambda _, track: f"{track} tumbler",
    "place": lambda _, pin: f"link {pin[0]}-{pin[0] + 1} {pin[1]}",
}
"""Names of items by dimension; "place" stands for a pin.

The coordinates of other dimensions, such as wheels, are names already.
"""


def run_figures(
    history: History, shoes: Sequence[int] = SHOES, series: Mapping[str, Series] | None = None
) -> dict[str, Figure]:
    """Return figures of some shoes' motion and contact, link forces, rollers and the side frame.

    `series` are the results of `history_series` if they exist already.
    """
    case = history.case
    by_label = history_series(history) if series is None else series
    links = sorted({min(shoe, case.track.shoe_count - 1) for shoe in shoes})
    of_shoes = [f"shoe {shoe}" for shoe in shoes]
    of_links = [f"link {link}-{link + 1}" for link in links]
    items = [*of_shoes, *of_links]
    panels = {
        name: _panels(by_label, labels, items) for name, labels in OF_RUNS.items() if labels[0] in by_label
    }
    if LABEL["roller_force"] in by_label:
        force = LABEL["roller_force"]
        on_shoes = LABEL["rail_force"]
        sides = [ON_RAILS.format(side) for side in history.rail.values]
        panels[force] = _panels(by_label, [force, *sides], axis="z")
        loaded = items if case.flexible is None else [f"shoe {shoe}" for shoe in case.flexible.shoes]
        panels[on_shoes] = _panels(by_label, [on_shoes], loaded)
        # the travel along x is an input
        rising = _panels(by_label, [LABEL["side_frame_displacement"]], axis="z")
        pull, turning = (_panels(by_label, [LABEL[name]]) for name in ("drive_pull", "side_frame_angles"))
        panels["side frame"] = [*pull, *rising, *turning]
    figures = {}
    if LABEL["wheel_force"] in by_label:
        wheels = by_label[LABEL["wheel_force"]]
        others = [item for item in wheels.items if "roller" not in item]
        panels["force on the rollers"] = wheels.panels([item for item in wheels.items if item not in others])
        panels["force on idler and carriers"] = wheels.panels(others)
        tracks = each_track(history).items()
        figures = {f"tension along the {name}chain": chain_figure(line) for name, line in tracks}
    return _figures(case.name, panels, history) | figures


def chain_figure(history: History) -> Figure:
    """Draw the tension of a closed chain over a run: around the loop, by position and by link."""
    along = summary.tension_along_chain(history)
    with style.titled_figure(f"{history.case.name}: tension along the chain", PANEL_WIDTH, 8.4) as figure:
        loop, by_place, by_link = figure.subplots(3, 1, height_ratios=[1.25, 1.0, 1.0])
        mean = along.mean_at / style.KILO
        look = {"cmap": style.SINKAGE_MAP, "edgecolors": style.SHOE_EDGE}
        dots = loop.scatter(along.x, along.z, c=mean, s=60.0, **look)
        above = {"xytext": (0, 6), "textcoords": "offset points", "ha": "center", "fontsize": NAME_SIZE}
        for place, x, z in zip(along.place.values, along.x.values, along.z.values, strict=True):
            if place % 2:
                loop.annotate(str(place), (x, z), **above)
        loop.set(aspect="equal", xlabel="x in the side frame in m", ylabel="z in m", ymargin=0.2)
        figure.colorbar(dots, ax=loop, label="mean tension in kN", fraction=0.02, pad=0.01)
        kinds = (
            (by_place, "place", "_at", "place on the loop"),
            (by_link, "joint", "", "link, by its rear shoe"),
        )
        for ax, dim, suffix, label in kinds:
            least, middle, most = (
                along[f"{name}{suffix}"] / style.KILO for name in ("least", "mean", "greatest")
            )
            how = {"color": style.SHOE, "alpha": 0.5, "step": "mid", "label": "least to greatest"}
            ax.fill_between(along[dim], least, most, **how)
            ax.step(along[dim], middle, where="mid", color=style.SHOE_EDGE, label="mean")
            ax.set(xlabel=label, ylabel="tension in kN", xlim=(0.5, along.sizes[dim] + 0.5))
        parts = along.part.values
        begins = [k for k in range(len(parts)) if k == 0 or parts[k] != parts[k - 1]]
        for number, (begin, end) in enumerate(zip(begins, [*begins[1:], len(parts)], strict=True)):
            _band(by_place, number, begin + 0.5, end + 0.5, parts[begin])
        by_link.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    return figure


def stress_figures(
    history: History, stress: xr.Dataset, series: Mapping[str, Series] | None = None
) -> dict[str, Figure]:
    """Return figures 11 to 17 and 21 of the S-paper: flexible shoes over the cycle.

    `series` are the results of `history_series` if they exist already.
    """
    shoes = history.flexible_shoe.values
    by_label = history_series(history, stress) if series is None else series
    items = [f"shoe {shoe}" for shoe in shoes]
    drawn = {name: [KINEMATICS.get(name, name)] for name in OF_FLEXIBLE_SHOES}
    panels = {name: _panels(by_label, labels, items) for name, labels in drawn.items()}
    for name, label in OF_PINS.items():
        for side in history.pin.values:
            # the name of the figure tells the side; the names of the curves tell the links
            pins = [item for item in by_label[label].items if item.endswith(f" {side}")]
            links = [item.removesuffix(f" {side}") for item in pins]
            values = by_label[label].values.sel(item=pins).assign_coords(item=links)
            panels[f"{side} {name}"] = replace(by_label[label], values=values).panels()
    if (deformation := LABEL["terrain_deformation"]) in by_label:
        panels["terrain deformation"] = _panels(by_label, [deformation])
    panels["modal coordinates"] = []
    for shoe in shoes:
        modes = history.modal_coordinate.sel(flexible_shoe=shoe).isel(mode=slice(MODES_DRAWN))
        named = {f"{float(line.frequency):.0f} Hz": line for line in modes.transpose("mode", "time")}
        panels["modal coordinates"].append(Panel(f"shoe {shoe}", "kg0.5 m", named))
    highest = by_label[LABEL["highest_von_mises"]]
    each = {item: highest.values.sel(item=item, axis="") for item in highest.items}
    panels[highest.label] = [Panel(item, highest.unit, {item: line}) for item, line in each.items()]
    return _figures(f"{history.case.name}, flexible shoes", panels, history)


def roller_path_figure(table: pd.DataFrame, name: str) -> Figure:
    """Draw the pressure of the treads along the rail beside the limits of materials.

    `table` is the result of `roller_path.roller_path`.
    """
    with style.titled_figure(f"{name}: roller path", PANEL_WIDTH, 0.5 * PANEL_WIDTH) as figure:
        ax = figure.subplots()
        on_rail = table["place"] == roller_path.RAIL
        columns = {roller_path.PRESSURE: "greatest", roller_path.TYPICAL: "median of the passes"}
        for column, label in columns.items():
            (line,) = ax.plot(roller_path.MIDDLE, column, data=table[on_rail], marker="o", label=label)
            ends = table[~on_rail]
            ax.plot(ends[roller_path.MIDDLE], ends[column], "s", color=line.get_color(), mfc="none")
        for number, material in enumerate(roller_path.MATERIALS):
            limits = zip(roller_path.limits(material), ("first yield", "shakedown"), ("--", "-"), strict=True)
            for limit, words, dash in limits:
                label = f"{words} of {material.name}"
                ax.axhline(limit / style.MEGA, ls=dash, lw=0.7, color=f"C{number + 2}", label=label)
        ax.set(xlabel="x in the shoe in m; squares: a disc on the rail's very end", ylabel="pressure in MPa")
        ax.set_ylim(bottom=0.0)
        figure.legend(loc="outside right upper")
    return figure


def drive_work_figure(table: pd.DataFrame, name: str) -> Figure:
    """Draw the mean power that each place takes after the start; `table` is that of `drive_work`."""
    taken = table[~table["where"].isin([drive_work.DRIVE, drive_work.LOAD])][::-1]
    given = float(table.loc[table["where"] == drive_work.DRIVE, drive_work.POWER].iloc[0])
    title = f"{name}: where the drive's power goes after the start"
    with style.titled_figure(title, PANEL_WIDTH, 0.4 * PANEL_WIDTH) as figure:
        ax = figure.subplots()
        ax.barh(taken["where"], taken[drive_work.POWER])
        for row, power in enumerate(taken[drive_work.POWER]):
            ax.text(max(power, 0.0), row, f" {power:.2f} kW, {100.0 * power / given:.1f} %", va="center")
        ax.axvline(given, color="black", lw=0.7, ls="--", label=f"drive, {given:.3g} kW")
        ax.margins(x=0.1)
        ax.set(xlabel="mean power in kW")
        figure.legend(loc="outside right upper")
    return figure


def _figures(title: str, panels: Mapping[str, Sequence[Panel]], history: History) -> dict[str, Figure]:
    """Return figures by name; the names are part of their titles."""
    phases = common_phases(history)
    return {name: panel_figure(f"{title}: {name}", panel, phases) for name, panel in panels.items()}


def _panels(
    by_label: Mapping[str, Series], labels: Sequence[str], items: Sequence[str] = (), axis: str = ""
) -> list[Panel]:
    """Return panels of some quantities: each with the given items that it has, or with all of its items."""
    panels = []
    for series in (by_label[label] for label in labels):
        values = series.values.sel(axis=[axis]) if axis else series.values
        chosen = [item for item in items if item in series.items]
        panels += replace(series, label=SHORT.get(series.label, series.label), values=values).panels(
            chosen or None
        )
    return panels
