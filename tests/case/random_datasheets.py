"""Datasheets drawn at random within plausible ranges, some of which contradict themselves."""

from typing import Any

import numpy as np

KINDS = ("excavator", "dozer", "loader", "shovel", "crane", "drill", "paver")


def drawn(seed: int) -> dict[str, Any]:
    """Values of a datasheet of this seed: sizes by the machine's weight, each off by some, some left out."""
    rng = np.random.default_rng(seed)
    kind = KINDS[rng.integers(len(KINDS))]
    mass = float(np.exp(rng.uniform(np.log(8e3), np.log(9e5))))
    if kind == "shovel":
        mass *= 1.5

    def off(value: float, by: float = 0.1) -> float:
        return float(f"{value * rng.uniform(1.0 - by, 1.0 + by):.4g}")

    size = (1e-3 * mass) ** (1.0 / 3.0)
    pitch = off(0.066 * size)
    on_ground = off(1.2 * size)
    circle = pitch / np.sin(np.pi / rng.uniform(9.5, 13.5))
    values: dict[str, Any] = {
        "kind": kind,
        "operating_weight": mass,
        "shoe_width": off(0.22 * size, 0.3),
        "gauge": off(0.78 * size),
        "length_on_ground": on_ground,
    }
    if rng.random() < 0.5:
        values["shoes"] = round(off((2.0 * on_ground + np.pi * circle) / pitch, 0.02))
    if rng.random() < 0.5:
        values["pitch"] = pitch
    if rng.random() < 0.6:
        values["crawler_length"] = off(on_ground + circle + 0.9 * pitch, 0.03)
    if rng.random() < 0.3:
        values["lower_rollers"] = int(rng.integers(5, 13))
    if rng.random() < 0.3:
        values["carrier_rollers"] = int(rng.integers(0, 5))
    if rng.random() < 0.3:
        values["grouser_height"] = off(0.15 * pitch, 0.6)
    if rng.random() < 0.3:
        values["drawbar_pull"] = off(0.7 * mass * 9.81, 0.3)
    if rng.random() < 0.3:
        values["shoe_weight"] = off(0.15 * mass / (2.0 * on_ground / pitch * 1.3) / 2.0, 0.3)
    if rng.random() < 0.2 and "crawler_length" in values:
        values["ground_pressure"] = off(mass * 9.81 / (2.0 * values["shoe_width"] * on_ground * 1.08), 0.03)
        del values["length_on_ground"]
    if rng.random() < 0.1:
        values["sprocket"] = "front"
    if rng.random() < 0.2:
        values["com_ahead"] = off(0.05 * on_ground, 2.0)
    if rng.random() < 0.2:
        values["sag"] = off(0.012 * on_ground, 0.6)
    if rng.random() < 0.2:
        values["travel_speed"] = off(1.0, 0.7)
    if rng.random() < 0.2:
        values["upper_weight"] = off(0.4 * mass, 0.2)
    if rng.random() < 0.2 and values.get("lower_rollers", 0) > 5:
        values["bogies"] = int(rng.integers(1, values["lower_rollers"] // 2 + 1))
    return values
