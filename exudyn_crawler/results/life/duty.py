"""Duty of a shovel: runs and check cases of its hours, their frequency, and the strength of its shoes.

The strength follows from local stresses by the FKM guideline ("Analytical Strength Assessment of Components",
Forschungskuratorium Maschinenbau, 6th ed., 2012), with the formulas of pyLife.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, Self, get_args

import numpy as np
import pandas as pd

from exudyn_crawler.case.parameters.base import Survival
from exudyn_crawler.results.stress.hot_spots import Region
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, option, quantity
from exudyn_crawler.settings.reading import read_parameters
from fem.fatigue import defects, sn_curve

FKMClass = Literal["steel", "forged steel", "case-hardened steel", "stainless steel", "cast steel"]
PYLIFE_CLASSES = dict(
    zip(get_args(FKMClass), ("Steel", "Forg_Steel", "CaseHard_Steel", "Stainless_Steel", "GS"), strict=True)
)
"""PyLife's names of the material classes."""
CASTINGS: dict[str, Any] = {"fkm_class": "cast steel", "casting_factor": 1.25, "scatter": 1.4}
MEGA = 1e6
MICRO = 1e-6
MILLI = 1e-3
HARDNESS = 3.2  # tensile strength of steel over its Vickers hardness, MPa


class Casting(Parameters):
    """Properties of the casting in a region of a shoe."""

    region: Literal["all"] | Region = option(
        "region of the shoe; all: every region without its own table", default="all"
    )
    residual_stress: float = quantity(
        "Pa",
        "residual stress, added to the mean of every cycle; tension positive",
        (-6e8, 4e8),
        ge=-3e9,
        le=3e9,
        default=0,
    )
    defect_size: float = quantity(
        "m", "sqrt(area) of a surface defect; 0: none", (0.0, 0.02), ge=0, le=0.1, default=0
    )


class FatigueMaterial(Parameters):
    """Cyclic strength of the shoes' material."""

    name: Name = option("name of the material")
    source: str = option("source of the values, and assumptions", "", max_length=1000)
    tensile_strength: float = quantity(
        "Pa", "tensile strength R_m, from the standard or a specimen", plausible=(2e8, 2.5e9), ge=1e7, le=1e10
    )
    yield_strength: float = quantity(
        "Pa", "yield strength R_e or R_p0.2", plausible=(1e8, 2e9), ge=1e7, le=1e10
    )
    fkm_class: FKMClass = option("material class of the FKM guideline, for its constants")
    size_factor: float = quantity(
        "1", "strength in the part over the specimen's (FKM: K_d K_A)", (0.6, 1.0), gt=0.1, le=1, default=1.0
    )
    roughness: float = quantity(
        "m",
        "surface roughness R_z; 2e-4: skin of casting or rolling (FKM 4.3.1.4)",
        (1e-6, 5e-4),
        ge=1e-6,
        le=1e-2,
        default=2e-4,
    )
    stress_gradient: float = quantity(
        "1/m",
        "related stress gradient at notches (FKM 4.3.1.3.1, Stieler); 0: no support effect",
        (0.0, 2e3),
        ge=0,
        le=1e5,
        default=0.0,
    )
    casting_factor: float = quantity(
        "1",
        "factor of casting defects (FKM: tested castings 1.25, others 1.4)",
        (1.0, 2.0),
        ge=1,
        le=10,
        default=1.0,
    )
    slope: float = quantity(
        "1", "slope k of the S-N curve (FKM: 5 for normal stress)", (3.0, 15.0), ge=1, le=50, default=5.0
    )
    knee: float = quantity(
        "1",
        "number of cycles at the knee of the S-N curve (FKM: 1e6)",
        (1e5, 1e7),
        ge=1e3,
        le=1e10,
        default=1e6,
    )
    scatter: float = quantity(
        "1", "scatter: strength with 10 % survival over that with 90 %", (1.0, 2.0), ge=1, le=10, default=1.25
    )
    survival: float = quantity(
        "1", "probability of survival of the strength (FKM: 0.975)", gt=0, lt=1, default=0.975
    )
    fatigue_strength: float | None = quantity(
        "Pa",
        "stress amplitude at the knee for R = -1, polished; none: by the FKM guideline",
        (5e7, 1e9),
        ge=1e6,
        le=1e10,
        default=None,
    )
    mean_sensitivity: float | None = quantity(
        "1",
        "mean stress sensitivity M; none: by FKM 4.4.2.1.2",
        plausible=(0.0, 0.8),
        ge=0,
        lt=1,
        default=None,
    )
    hardness: float | None = quantity(
        "1", "Vickers hardness HV; none: R_m / 3.2 MPa (ISO 18265)", (100, 700), ge=50, le=2000, default=None
    )
    crack_size: float = quantity(
        "m", "size sqrt(area) from which a growing defect counts as a crack", gt=1e-3, le=0.5, default=0.06
    )
    castings: tuple[Casting, ...] = option("defects and residual stress by region", default=())

    def _errors(self) -> Errors:
        strength = self.tensile_strength
        limit = fields.quantity_text(strength, "Pa")
        least = self.yield_strength
        if least > strength:
            got = fields.quantity_text(least, "Pa")
            yield f"yield_strength must not exceed tensile_strength = {limit}, got {got}"
        if self.fatigue_strength is not None and self.fatigue_strength > strength:
            yield (
                f"fatigue_strength must not exceed tensile_strength = {limit}, got "
                f"{fields.quantity_text(self.fatigue_strength, 'Pa')}"
            )
        regions = [casting.region for casting in self.castings]
        if double := sorted({region for region in regions if regions.count(region) > 1}):
            yield f"castings: regions must differ, got {double} twice"

    @classmethod
    def a36(cls) -> Self:
        """Return structural steel ASTM A36, given as the material of the papers' shoe; rolled, not cast."""
        return cls(
            name="A36",
            source="ASTM A36: least yield and tensile strength; scatter and rolling skin assumed",
            tensile_strength=400e6,
            yield_strength=250e6,
            fkm_class="steel",
        )

    @classmethod
    def cast_nicrmo(cls) -> Self:
        """Return quenched and tempered NiCrMo cast steel, a usual shoe material, without hardened layer."""
        return cls(
            name="cast NiCrMo",
            source="yield as makers of shoes give it; tensile strength in the ratio of ASTM A148 120-95, "
            "tested castings, skin and scatter assumed; the hardened roller path counts as its core",
            tensile_strength=860e6,
            yield_strength=690e6,
            **CASTINGS,
        )

    @classmethod
    def cast_manganese(cls) -> Self:
        """Return austenitic manganese steel (Hadfield), water-quenched, without its hardening in service."""
        return cls(
            name="austenitic manganese",
            source="ASTM A128, typical strengths of thick castings assumed; FKM has no such class, that of "
            "cast steel stands for it; tested castings, skin and scatter assumed",
            tensile_strength=760e6,
            yield_strength=350e6,
            **CASTINGS,
        )

    def provenance(self) -> str:
        """Return the source of the values; for a changed ready material also names of the changed values."""
        ready = {
            material.source: material for material in (self.a36(), self.cast_nicrmo(), self.cast_manganese())
        }
        original, names = ready.get(self.source, self), [*type(self).model_fields][1:]  # but for the name
        changed = [name for name in names if getattr(self, name) != getattr(original, name)]
        return f"{', '.join(changed)} as the duty gives; all else: {self.source}" if changed else self.source

    def factors(self) -> dict[str, float]:
        """Return the factors of the strength.

        The strength at the knee is fatigue_strength (Pa) over design and casting_factor.
        """
        strength = self.size_factor * self.tensile_strength / MEGA
        settings = {name: getattr(self, name) for name in ("fatigue_strength", "mean_sensitivity")}
        factors = _fkm_factors(self.fkm_class, strength, self.roughness / MICRO, MILLI * self.stress_gradient)
        return factors | {name: value for name, value in settings.items() if value is not None}

    def casting(self, region: str) -> Casting:
        """Return the casting of a region."""
        known: dict[str, Casting] = {casting.region: casting for casting in self.castings}
        return known.get(region, known.get("all", Casting()))

    def defect_life(
        self, region: str, miner: sn_curve.Miner, stages: Sequence[defects.CycleStage], survival: float
    ) -> float:
        """Return the time to a crack from a region's defect under cycles of stages; NaN without one."""
        size = self.casting(region).defect_size
        if not size:
            return np.nan
        hardness = self.tensile_strength / MEGA / HARDNESS if self.hardness is None else self.hardness
        curve = self.curve(miner, region)
        sound = replace(curve, strength=curve.strength * self.casting_factor)
        return defects.defect_life(defects.Defect(size, hardness, self.crack_size), sound, stages, survival)

    def curve(self, miner: sn_curve.Miner = "elementary", region: str = "") -> sn_curve.SNCurve:
        """Return the S-N curve of the part's surface by local stresses, with the region's residual stress."""
        factors = self.factors()
        return sn_curve.SNCurve(
            strength=factors["fatigue_strength"] / factors["design"] / self.casting_factor,
            slope=self.slope,
            knee=self.knee,
            mean_sensitivity=factors["mean_sensitivity"],
            scatter=self.scatter,
            survival=self.survival,
            miner=miner,
            residual_stress=self.casting(region).residual_stress,
        )


@lru_cache(maxsize=64)
def _fkm_factors(kind: FKMClass, strength: float, roughness: float, gradient: float) -> dict[str, float]:
    """Return the factors of `FatigueMaterial.factors` by the guideline.

    Units are MPa of the strength, um of the roughness R_z, and 1/mm of the stress gradient.
    """
    from pylife.strength.fkm_linear.fkm_functions import FkmLinearFunctions

    fkm = FkmLinearFunctions()
    normal = pd.Series(["normal"])
    unity = pd.Series([1.0])
    name = pd.Series([PYLIFE_CLASSES[kind]])
    size = pd.Series([strength])
    constants, of_stress = fkm.get_material_constants(name, normal)
    of_steel = constants, of_stress, normal
    rough = fkm.rough_factor(size, pd.Series([roughness]), *of_steel, pd.Series(["rough"]))
    support = fkm.stieler_support(*of_steel, pd.Series([gradient]), size)
    factors = {
        "fatigue_strength": MEGA * fkm.reversed_mat_strength_chap4(size, *of_steel),
        "roughness": rough,
        "support": support,
        "design": fkm.design_factor(support, fkm.kf_constant(name), rough, unity, unity, unity),
        "mean_sensitivity": np.maximum(0.0, fkm.sm_sensitivity_chap4(size, *of_steel)),
    }
    return {name: float(np.ravel(values)[0]) for name, values in factors.items()}


HOUR = 3600.0  # s
UNLOADED = "unloaded"
"""Name of the state without loads, among the names of check cases."""


class Often(Parameters):
    """Part of a run and its frequency: repetitions in a machine hour, or a share of the machine hours."""

    begin: float = quantity("s", "time in the run at which the repeated part begins", ge=0, default=0.0)
    end: float | None = quantity(
        "s", "time in the run at which the repeated part ends; none: the run's end", gt=0, default=None
    )
    an_hour: float | None = quantity(
        "1/h", "repetitions in a machine hour; alternative: `share`", gt=0, le=1e6, default=None
    )
    share: float | None = quantity(
        "1", "fraction of the machine hours; alternative: `an_hour`", gt=0, le=1, default=None
    )


class DutyStage(Parameters):
    """Stage of wear: hours in which the shoes are those of a check file."""

    name: Name = option("name of the stage")
    hours: float = quantity("h", "machine hours of the stage; the last one goes on", (0.1, 1e6), gt=0, le=1e9)
    check: str | None = option("check file or mesh of the shoes in this stage; none: that of the duty", None)


class DutyCase(Parameters):
    """Check case that occurs in a shovel's hours."""

    name: Name = option("name of the event")
    case: Name = option("name of a check case of the shoes, such as 'even, sand, pass'")
    after: Name = option("check case from which the shoe comes and to which it returns", UNLOADED)
    an_hour: float = quantity("1/h", "repetitions on a shoe in a machine hour", gt=0, le=1e6)
    load: float = quantity("1", "factor of the stress in both cases", (0.2, 5.0), gt=0, le=100, default=1.0)
    stage: Name | None = option("stage of wear in which the event happens; none: all stages", None)


class DutyRun(Often):
    """Run, or part of one, that repeats in a shovel's hours."""

    name: Name = option("name of the run in tables")
    stage: Name | None = option("stage of wear to which the run belongs; none: all stages", None)
    folder: str = option("folder of the run, relative to the duty file's folder", min_length=1)

    def _errors(self) -> Errors:
        if (self.an_hour is None) == (self.share is None):
            yield "an_hour or share must be given, got neither or both"
        if self.end is not None and self.end <= self.begin:
            yield f"end must be after begin = {self.begin:g} s, got {self.end:g} s"

    def times_an_hour(self, duration: float) -> float:
        """Return the number of repetitions in a machine hour, for a duration in s."""
        return self.an_hour if self.an_hour is not None else (self.share or 0.0) * HOUR / duration


class DamageOptions(Parameters):
    """Material of the shoes, and rules to sum the damage of its cycles."""

    material: FatigueMaterial = option("cyclic strength of the shoes' material")
    criterion: Literal["signed von mises", "signed principal"] = option(
        "stress for the count of cycles at all nodes: von Mises with the sign of the hydrostatic stress, or "
        "the principal stress of the greatest magnitude",
        "signed von mises",
    )
    miner: sn_curve.Miner = option(
        "damage of cycles below the knee: elementary by the same slope (the safest), haibach less "
        "(slope 2 k - 1), original nothing",
        "elementary",
    )


class Duty(DamageOptions):
    """Mix of runs and check cases in a shovel's hours, with material and wear of its shoes."""

    name: Name = option("name of the duty", "duty")
    runs: tuple[DutyRun, ...] = option("runs with flexible shoes", ())
    cases: tuple[DutyCase, ...] = option("static cases, one cycle each", ())
    check: str = option("check file or mesh of the shoes, with their check cases", "study")
    stages: tuple[DutyStage, ...] = option("stages of wear, in order from new shoes on; none: no wear", ())
    survivals: tuple[Survival, ...] = option(
        "probabilities of survival of the shown lives", (0.5, 0.9, 0.975), min_length=1
    )
    plane_nodes: int = quantity(
        "1", "number of worst nodes with a search for the critical plane", ge=0, le=100_000, default=100
    )
    nodes: tuple[int, ...] = option(
        "surface nodes with stored cycles, beside the worst one of each region", ()
    )
    changes_an_hour: float | None = quantity(
        "1/h",
        "greatest number of changes of a shoe between two runs or cases in an hour; none: the lower "
        "of both rates",
        ge=0,
        le=1e6,
        default=None,
    )

    def _errors(self) -> Errors:
        names = [part.name for part in self.parts]
        stages = [stage.name for stage in self.stages]
        if not names:
            yield "runs or cases must be given, got neither"
        for what, several in (("runs'", names), ("stages'", stages)):
            if len(set(several)) != len(several):
                yield f"the {what} names must differ, got {fields.shown(several)}"
        if unknown := {part.stage for part in self.parts} - {*stages, None}:
            yield f"stage must be one of {stages}, got {fields.shown(sorted(map(str, unknown)))}"
        if list(self.survivals) != sorted(set(self.survivals)):
            yield f"survivals must be different and rise, got {fields.shown(self.survivals)}"
        for duty in self.by_stage():
            _check_shares({run.name: run.share for run in duty.runs if run.share is not None})

    @property
    def most_changes(self) -> float:
        """Greatest number of changes an hour from one run or case to another and back."""
        return math.inf if self.changes_an_hour is None else self.changes_an_hour

    @property
    def parts(self) -> tuple[DutyRun | DutyCase, ...]:
        """Runs and cases."""
        return (*self.runs, *self.cases)

    def by_stage(self) -> "list[Duty]":
        """Return the duty of each stage alone, named as the stage; ValueError for a stage without events."""
        duties = []
        for name, check in ((stage.name, stage.check or self.check) for stage in self.stages):
            parts = [part.with_(stage=None) for part in self.parts if part.stage in (None, name)]
            runs, cases = ([part for part in parts if isinstance(part, kind)] for kind in (DutyRun, DutyCase))
            duties.append(self.with_(name=name, stages=(), check=check, runs=runs, cases=cases))
        return duties or [self]

    def times_an_hour(self, durations: list[float]) -> list[float]:
        """Return the repetitions of each run in an hour, for durations in s.

        ValueError if all runs together take more than an hour.
        """
        times = {
            run.name: run.times_an_hour(duration) for run, duration in zip(self.runs, durations, strict=True)
        }
        _check_shares(
            {name: times[name] * duration / HOUR for name, duration in zip(times, durations, strict=True)}
        )
        return list(times.values())


def _check_shares(shares: dict[str, float]) -> None:
    whole = sum(shares.values())
    if whole > 1.0 + 1e-9:
        taken = ", ".join(f"{name} {share:.4g}" for name, share in shares.items())
        raise ValueError(
            f"the runs must not take more than all machine hours, got {whole:.4g} of them: {taken}"
        )


def read_duty(path: str | Path) -> Duty:
    """Read a duty file (TOML); folders and check files are relative to its folder; raise as `read_case`."""
    path = Path(path)
    duty = read_parameters(path, Duty, "duty file", lambda content: {"name": path.stem} | content)

    def resolved(check: str) -> str:
        file = path.parent / check
        return str(file.resolve()) if file.is_file() else check

    return duty.with_(
        runs=tuple(run.with_(folder=str((path.parent / run.folder).resolve())) for run in duty.runs),
        stages=tuple(stage.with_(check=resolved(stage.check or duty.check)) for stage in duty.stages),
        check=resolved(duty.check),
    )
