"""Tests of a soil made from a law, with noise."""

import numpy as np

from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.shear import COHESION_PRESSURE
from exudyn_crawler.results.measured.soil_tests import PlateTests, ShearTests

SOIL = BekkerSoil.lete_sand().with_(reload_stiffness=1e8, reload_growth=5e9)
WIDTHS, PRESSURES = (0.05, 0.1, 0.2), (20e3, 60e3, 120e3)
LOOPS = (0.02, 0.05)
"""Sinkages (m) from which plates are unloaded by 0.5 mm; the first time they are loaded again."""


def plates(noise=0.0, seed=0, widths=WIDTHS, repeats=1, scatter=0.0, law=SOIL, unloaded=True):
    """Plate tests in closed form; noise is of the greatest pressure, `scatter` that of a test's modulus."""
    random = np.random.default_rng(seed)
    up = [np.linspace(0.002, 0.02, 15), np.linspace(0.02, 0.05, 16)[1:]]
    down = [deepest - np.linspace(0.0, 5e-4, 9)[1:] for deepest in LOOPS]
    legs = [up[0], down[0], down[0][::-1], up[1], down[1]] if unloaded else up
    begins = [None, LOOPS[0], LOOPS[0], None, LOOPS[1]] if unloaded else [None, None]
    columns = []
    for width in widths:
        for repeat in range(repeats):
            modulus = (law.k_c / width + law.k_phi) * (1.0 + scatter * random.standard_normal())
            pressure = [
                modulus * leg**law.exponent
                if begin is None
                else modulus * begin**law.exponent
                - (law.reload_stiffness + law.reload_growth * begin) * (begin - leg)
                for leg, begin in zip(legs, begins, strict=True)
            ]
            sinkage = np.concatenate(legs)
            measured = np.concatenate(pressure)
            measured += noise * measured.max() * random.standard_normal(len(sinkage))
            name = np.full(len(sinkage), f"{width} {repeat}")
            columns.append((sinkage, measured, np.full(len(sinkage), width), name))
    return PlateTests(*map(np.concatenate, zip(*columns, strict=True)))


def shear(noise=0.0, seed=0, pressures=PRESSURES, longest=0.06, law=SOIL):
    """Shear tests in closed form; noise is of the greatest stress of all."""
    random = np.random.default_rng(seed + 10_000)
    slip = np.linspace(0.0, longest, 25)[1:]
    friction = np.tan(np.radians(law.friction_angle))
    columns = []
    for pressure in pressures:
        strength = pressure * (friction + law.cohesion / (pressure + COHESION_PRESSURE))
        stress = -strength * np.expm1(-slip / law.shear_deformation)
        stress += noise * 75e3 * random.standard_normal(len(slip))
        columns.append((slip, stress, np.full(len(slip), pressure), np.full(len(slip), f"{pressure}")))
    return ShearTests(*map(np.concatenate, zip(*columns, strict=True)))


def plate_text(tests):
    """Plate tests as a table in other units, with brackets in its head."""
    rows = zip(tests.test, 1e3 * tests.width, 1e3 * tests.sinkage, 1e-3 * tests.pressure, strict=True)
    lines = [f"{name},{width:.17g},{sinkage:.17g},{pressure:.17g}" for name, width, sinkage, pressure in rows]
    return "\n".join(["# made", 'test,width in mm,sinkage [mm],"pressure, kPa"', *lines])


def shear_text(tests):
    """Shear tests as a table with semicolons and decimal commas."""
    rows = zip(1e3 * tests.displacement, 1e-3 * tests.stress, 1e-3 * tests.pressure, strict=True)
    lines = [";".join(f"{value:.17g}".replace(".", ",") for value in row) for row in rows]
    return "\n".join(["displacement (mm);stress (kPa);pressure (kPa)", *lines])
