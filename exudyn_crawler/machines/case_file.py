"""Case file: a case, the duration of its run and its outputs; size checks, text and comparison."""

import math
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal, NamedTuple, SupportsFloat

import tomlkit
from annotated_types import Ge
from pydantic import BaseModel

from exudyn_crawler.case import statics
from exudyn_crawler.case.case import Case
from exudyn_crawler.case.parameters import drive
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, Parameters, Rising, option, quantity
from meshes import geometry, mesh_named

NUMBER = 8  # bytes
FALLBACK_MEMORY = 64e9  # assumed memory, bytes, if the system does not tell it
GREATEST_HISTORY = 1e12  # size limit of a history on disk, bytes
A_UNIT = 20e3  # memory of a unit that is a body of the multibody system with its joints, bytes
HEAD = 'Case of exudyn-crawler, in SI units; "none" stands for no value.'
IN_WORDS = 'Numbers are in the units of their comments, or texts with units: "20 MN/m", "9 km/h", "5 min".'
DIGITS = 10  # significant digits of a number in a file for editing by hand; further ones are rounding
Time = Annotated[float, Ge(0.0)]
MANIFOLD = 2.0  # ratio above which a difference is shown as a ratio, not in per cent
ABSENT = "-"  # stands for a missing value


def check_run(case: object, duration: object) -> None:
    """Raise `TypeError` for an object that is no `Case`, `ValueError` for an impossible run (s)."""
    if not isinstance(case, Case):
        how = "such as Case.translation() or read_case(path).case"
        raise TypeError(f"case must be a Case, {how}, got {fields.shown(case)}")
    if not isinstance(duration, SupportsFloat):
        raise ValueError(f"duration must be a number in s, got {duration!r}")
    if not 0.0 < float(duration) < math.inf:
        raise ValueError(f"duration must be positive and finite, got {duration!r} s")
    check_size(case, float(duration))
    case.check_support(float(duration))


def check_case_file(case_file: object) -> None:
    """Raise `TypeError` for an object that is no `CaseFile`; the message says how to get one."""
    if not isinstance(case_file, CaseFile):
        how = "such as CaseFile(case=case, duration=10.0) or read_case(path)"
        raise TypeError(f"case_file must be a CaseFile, {how}, got {fields.shown(case_file)}")


def check_size(case: Case, duration: float) -> None:
    """Raise `ValueError` for a run (s) beyond this machine's memory or the size limit of a history."""
    terrain = case.terrain
    if terrain.model == "units":
        # singular value decomposition of the joints' equations in the heave and tilt of every unit
        needed = 4.0 * NUMBER * (2.0 * terrain.unit_count) ** 2
        allowed = machine_memory()
        if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
            needed = A_UNIT * terrain.unit_count
        if needed > allowed:
            size = f"{needed / 1e9:.3g} GB of memory, this machine has {allowed / 1e9:.3g} GB"
            raise ValueError(f"terrain: {terrain.unit_count} units would take {size}")
    times = case.solver.stored_times(duration, case.drive.quiet_time(duration))
    stored = times * stored_numbers(case) * NUMBER
    if stored > GREATEST_HISTORY:
        size = f"{stored / 1e12:.3g} TB, allowed is 1 TB"
        raise ValueError(
            f"duration: {duration:g} s would store {size}; a longer solver.output_interval reduces it"
        )


def machine_memory() -> float:
    """Return the memory of this machine, bytes."""
    if sys.platform != "win32":
        with suppress(OSError, ValueError):
            return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    return FALLBACK_MEMORY


def stored_numbers(case: Case) -> int:
    """Return the approximate size of a stored state: coordinates with two rates, units and contacts."""
    shoes = case.track.shoe_count
    units = len(case.terrain.units)
    modes = 0 if case.flexible is None else case.flexible.mode_count * len(case.flexible.shoes)
    return 60 * shoes + 6 * units + 3 * modes


class Outputs(Parameters):
    """Outputs of a run beside its history, whose interval is `solver.output_interval`."""

    figures: bool = option("figures of kinematics and forces over time", True)
    pictures: bool = option("pictures of the stress of flexible shoes at `picture_times`", True)
    paraview: bool = option("ParaView files of this stress, at `picture_times` and at its peak", True)
    figure_format: Literal["png", "pdf", "svg"] = option(
        "file format of the figures; pictures of stress are png", "png"
    )
    tables: bool = option("tables of extremes and loads (CSV)", True)
    animation: bool = option("animation of the track (mp4)", False)
    forces: bool = option("file of the forces derived from the history", True)
    page: bool = option("one page with all results, report.html", True)
    picture_times: Rising[Time] | None = quantity(
        "s",
        "times of stored and drawn stress fields, in addition to the peak; none: ends of phases",
        min_length=1,
        default=None,
    )
    ground_times: Rising[Time] = quantity(
        "s", "times of stored and drawn maps of ground of cells, in addition to the end", default=()
    )
    shoes: Rising[int] | None = option(
        "numbers of the drawn shoes; none: five along the track", None, min_length=1
    )

    def drawn_shoes(self, shoe_count: int) -> tuple[int, ...]:
        """Return the shoes of a track to draw: the chosen ones, else up to five, ends included."""
        if self.shoes is not None:
            return self.shoes
        count = min(5, shoe_count)
        return tuple(1 + round(k * (shoe_count - 1) / (count - 1)) for k in range(count))


BARE = Outputs(figures=False, pictures=False, paraview=False, forces=False, tables=False, page=False)
"""Outputs of one run among many: drawing all of their pictures would take longer than the runs."""


class CaseFile(Parameters):
    """Case with the duration of its run and the outputs."""

    case: Annotated[Case, fields.BESIDE]
    duration: float = quantity("s", "simulated time", default=10.0, allow_inf_nan=True)
    outputs: Outputs = Outputs()
    datasheet: Datasheet | None = option(
        "maker's figures, from which all values follow that the file does not state; none: no datasheet", None
    )

    def _errors(self) -> Errors:
        check_run(self.case, self.duration)
        count = self.case.track.shoe_count
        if beyond := [shoe for shoe in self.outputs.shoes or () if not 1 <= shoe <= count]:
            yield f"outputs.shoes must be in 1..{count}, got {fields.shown(beyond)}"
        for name in ("picture_times", "ground_times"):
            times = getattr(self.outputs, name)
            if times and times[-1] > self.duration:
                yield f"outputs.{name} must be in 0..{self.duration:g} s, got {fields.shown(list(times))}"


def case_text(case_file: CaseFile, by_hand: bool = False) -> str:
    """Return a case file as TOML with a comment for every value; `by_hand` with units as text, ten digits."""
    heads = (HEAD, *([IN_WORDS] if by_hand else ()), *_bases(Case))
    lines = [f"# {line}" for line in heads] + [""]
    for entry in fields.walk(case_file):
        if fields.is_table(entry.value):
            lines += _head(entry)
        else:
            words = ", ".join(part for part in (entry.unit, entry.meaning) if part)
            value = _toml(entry.value, entry.unit, by_hand)
            lines.append(f"{entry.place[-1]} = {value}" + (f" # {words}" if words else ""))
    return "\n".join(lines) + "\n"


def _head(entry: fields.Item) -> list[str]:
    """Return the first lines of a table: its name, its meaning, and the named values of its `base`."""
    name = ".".join(fields.names_of(entry.place))
    if isinstance(entry.place[-1], int):
        return ["", f"[[{name}]]"]
    comments = (entry.meaning, *_bases(*fields.models_of(entry.field.annotation)))
    return ["", f"[{name}]", *(f"# {line}" for line in comments)]


def _bases(*kinds: type[BaseModel]) -> list[str]:
    names = dict.fromkeys(f'"{name}"' for kind in kinds for name in fields.named_values(kind))
    return [f"{fields.BASE} = {' or '.join(names)} gives all values that are not stated"] if names else []


def typed_text(entry: fields.Item) -> str:
    """Return a value as a user types it, with its unit if it is a number, so that it can be read again."""
    value = entry.value
    if value is None or isinstance(value, str | bool | Path):
        return "" if value is None else fields.value_text(value)
    if fields.is_number(value):
        return fields.value_text(value, "" if "exponent" in entry.unit else entry.unit)
    return _toml(value, entry.unit, by_hand=True)


def _toml(value: object, unit: str, by_hand: bool) -> str:
    """Return a value as TOML; `by_hand` in kN, MPa and MN/m, and without digits from rounding."""
    if isinstance(value, tuple):
        # either all numbers of a list have a unit, or none
        has_units = by_hand and "exponent" not in unit and bool(fields.prefix_of(value, unit))
        items = (
            f'"{item:.{DIGITS}g} {unit}"'
            if has_units and isinstance(item, float) and item and not fields.prefix_of(item, unit)
            else _toml(item, unit, by_hand)
            for item in value
        )
        return f"[{', '.join(items)}]"
    if isinstance(value, drive.StepProfile):
        return "{" + ", ".join(f"{name} = {_toml(item, '', by_hand)}" for name, item in value) + "}"
    if isinstance(value, float):
        prefix = fields.prefix_of(value, unit) if by_hand and "exponent" not in unit else ""
        digits = f"{value / fields.PREFIXES[prefix]:.{DIGITS}g}"
        if prefix:
            return f'"{digits} {prefix}{unit}"'
        return fields.number_text(float(digits) if by_hand else value)
    value = str(value) if isinstance(value, Path) else value
    return tomlkit.item(fields.NONE if value is None else value).as_string()


def run_lines(case_file: CaseFile) -> list[str]:
    """Return lines on a case before its run: weights, pressure, sinkage, travel and steps.

    If a machine is on the track, `run.solve.standing` finds the pressure below its shoes at rest. A third
    line has the weights of rigid and of flexible shoes. Raise an error if the mesh of flexible shoes is
    missing.
    """
    case = case_file.case
    end = float(case_file.duration)
    shoes = case.track.shoe_count
    shoe = case.shoe
    weight = f"{shoe.mass / 1e3:.4g} t" if shoe.mass >= 1e3 else f"{shoe.mass:.4g} kg"
    track = f"track: {shoes} shoes of {weight}"
    if not case.gear.frame_parts:
        loads = shoes * statics.mean_load(case)
        pressure = loads / (shoes * shoe.ground_area)
        track += (
            f"; the ground carries {loads / 1e6:.4g} MN at the start, {pressure / 1e3:.4g} kPa below the "
            f"shoes, which sink by about {1e3 * statics.settled_penetration(case):.3g} mm"
        )
    way = float(case.drive.speed.integral(end))
    quiet = case.drive.quiet_time(end)
    size = f"{1e3 * case.solver.step:g} ms"
    if quiet and case.solver.quiet_step > case.solver.step:
        size += f", or {1e3 * case.solver.quiet_step:g} ms while the drive is off"
    lines = [
        track,
        f"run: {end:g} s, {abs(way):.3g} m of travel by the drive, "
        f"{case.solver.steps(end, quiet):.0f} steps of {size}, "
        f"{case.solver.stored_times(end, quiet):.0f} stored times",
    ]
    if case.flexible is not None:
        mesh = case.flexible.mesh
        # a case without its own mesh need not wait for the reading of one
        volume = geometry.VOLUMES[mesh] if mesh in geometry.VOLUMES else mesh_named(mesh).volume
        mass = volume * case.flexible.density
        each, flexible = (fields.quantity_text(one, "kg") for one in (shoe.mass, mass))
        weigh = f"rigid ones weigh {each} each, flexible ones {flexible}"
        ratio = mass / shoe.mass
        more = f"{100.0 * (ratio - 1.0):+.2g} %" if ratio < MANIFOLD else f"{ratio:.3g} times as much"
        lines.append(f"shoes: {weigh} ({more}), as their mesh and density make them")
    return lines


class Difference(NamedTuple):
    """Difference between two cases in one value."""

    key: str
    first: str  # with its unit
    second: str

    def __str__(self) -> str:
        return f"{self.key} is {self.first}, not {self.second}"


def differences(first: BaseModel, second: BaseModel) -> list[Difference]:
    """Return the values in which two cases or case files differ."""
    a, b = ({entry.path: entry for entry in fields.values_of(case)} for case in (first, second))
    return [
        Difference(key, *_texts(a.get(key), b.get(key)))
        for key in a | b
        if key not in a or key not in b or a[key].value != b[key].value
    ]


def _texts(*entries: fields.Item | None) -> tuple[str, str]:
    """Return two differing values as text, with all digits if fewer would hide the difference."""
    first, other = (ABSENT if has is None else fields.value_text(has.value, has.unit) for has in entries)
    if first == other:
        first, other = (ABSENT if has is None else f"{has.value!r} {has.unit}".rstrip() for has in entries)
    return first, other


def nearest_base(case: Case) -> tuple[str, dict[str, str]]:
    """Return the named case with the fewest differing values, name apart, and its own values of these."""

    def texts(values: Case) -> dict[str, str]:
        return {row.key: row.value for row in fields.case_rows(values.with_(name="case"))}

    case_texts = texts(case)
    from_bases = {}
    for name in fields.named_values(Case):
        base = texts(getattr(Case, name)())
        from_bases[name] = {
            key: base.get(key, ABSENT) for key in base | case_texts if base.get(key) != case_texts.get(key)
        }
    nearest = min(from_bases, key=lambda name: len(from_bases[name]))
    return nearest, from_bases[nearest]
