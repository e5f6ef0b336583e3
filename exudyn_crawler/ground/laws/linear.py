"""Law of Exudyn's `GeneralContact`: linear in depth and its rate, with one coefficient of friction."""

from typing import NamedTuple

from exudyn_crawler.ground.frames import compiled


class Linear(NamedTuple):
    """Parameters: `stiffness` (N/m), `damping` (N s/m), `friction`, `friction_speed` (m/s).

    Friction rises linearly with the slip to all of it at `friction_speed`.
    """

    stiffness: float
    damping: float
    friction: float
    friction_speed: float


@compiled
def linear_force(law: Linear, depth: float, rate: float) -> float:
    """Normal force (N) at a depth (m) and its rate (m/s); fast lifting pulls, as in the engine."""
    return law.stiffness * depth + law.damping * rate


@compiled
def linear_friction_per_slip(law: Linear, slip_speed: float) -> float:
    """Coefficient of friction over slip speed (s/m)."""
    return law.friction / max(slip_speed, law.friction_speed)
