"""Where the wall time of a run goes, by Exudyn's own clocks."""

import time as clock

import pandas as pd

from exudyn_crawler import Case
from exudyn_crawler.model.system import build
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.integration import integrate, solver_settings
from exudyn_crawler.views.tables import print_table

CASES = {"translation": Case.translation, "stress": Case.stress}


def split(case: Case, duration: float) -> dict[str, float]:
    """Wall seconds of each part of one run, by Exudyn's own clocks where it has them."""
    # the clocks count a stage, so that the run is to have one only
    case = case.with_(solver=case.solver.with_(checkpoint_interval=duration))
    system = build(case)
    system.set_initial(static_equilibrium(case))
    contact = system.contact
    spent = {"contact forces": 0.0, "contact derivatives": 0.0}

    def clocked(name, function):
        def wrapper(*args, **kwargs):
            start = clock.perf_counter()
            result = function(*args, **kwargs)
            spent[name] += clock.perf_counter() - start
            return result

        return wrapper

    contact.forces = clocked("contact forces", contact.forces)  # type: ignore[method-assign]
    contact.derivatives = clocked("contact derivatives", contact.derivatives)  # type: ignore[method-assign]
    settings = solver_settings(case.solver)
    settings.show.computationTime = True
    start = clock.perf_counter()
    integrate(system, duration, False, settings)
    total = clock.perf_counter() - start
    solver = system.mbs.sys["dynamicSolver"]
    timer = solver.timer
    parts = {
        "total": total,
        **spent,
        "rest of the right-hand side": timer.ODE2RHS
        + timer.AERHS
        + timer.massMatrix
        + timer.reactionForces
        - spent["contact forces"],
        "rest of the Jacobian": timer.totalJacobian - spent["contact derivatives"],
        "factorization": timer.factorization,
        "solution": timer.newtonIncrement,
    }
    parts["output and rest"] = total - sum(value for name, value in parts.items() if name != "total")
    parts["steps"] = solver.it.currentStepIndex - 1
    parts["iterations"] = solver.it.newtonStepsCount
    parts["Jacobians"] = solver.it.newtonJacobiCount
    return parts


def print_split(case: str, duration: float) -> None:
    """Print the split of a run."""
    parts = split(CASES[case](), duration)
    counts = {name: int(parts.pop(name)) for name in ("steps", "iterations", "Jacobians")}
    total = parts["total"]
    rows = [(k, v / duration, 1e3 * v / counts["steps"], f"{v / total:.0%}") for k, v in parts.items()]
    table = pd.DataFrame(rows, columns=["part", "wall s per simulated s", "ms per step", "share"])
    print_table(table, f"Split of {duration:g} s of {case}: {counts}")
