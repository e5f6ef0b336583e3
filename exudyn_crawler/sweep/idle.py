"""Values of a case that change nothing, for what else it has."""

from collections.abc import Callable, Iterable, Iterator

from exudyn_crawler.case import Case, PairContact, SphereContact


def _pair(case: Case, test: Callable[[PairContact], bool]) -> bool:
    return isinstance(case.contact, PairContact) and test(case.contact)


def _spheres(case: Case, test: Callable[[SphereContact], bool]) -> bool:
    return isinstance(case.contact, SphereContact) and test(case.contact)


IDLE: tuple[tuple[str, Callable[[Case], bool], str], ...] = (
    (
        "contact.edge_width",
        lambda case: _pair(case, lambda law: law.sharing == "area"),
        "contact.sharing 'area', by which the law grows with the overlap's area",
    ),
    (
        "contact.damping_depth",
        lambda case: _pair(case, lambda law: law.damping == 0.0),
        "contact.damping = 0",
    ),
    (
        "contact.stiction_speed",
        lambda case: _pair(case, lambda law: law.static_friction == 0.0),
        "contact.static_friction = 0",
    ),
    (
        "contact.friction_speed",
        lambda case: (
            _pair(case, lambda law: law.static_friction == 0.0)
            or _spheres(case, lambda law: law.friction == 0.0)
        ),
        "no friction",
    ),
    (
        "terrain.spring_offset",
        lambda case: case.terrain.springs_per_unit == 1,
        "terrain.springs_per_unit = 1, whose spring stands at the centre",
    ),
    ("solver.quiet_step", lambda case: case.drive.on is None, "a drive that never goes off"),
)
"""Paths, when they are idle, and why."""


def idle(paths: Iterable[str], case: Case) -> Iterator[str]:
    """Those of some paths whose values change nothing in a case, a line each."""
    wanted = set(paths)
    for path, is_idle, why in IDLE:
        if path in wanted and is_idle(case):
            yield f"{path}: it changes nothing with {why}"
