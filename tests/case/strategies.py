"""Random parameters for property-based tests, made from the parameter classes themselves.

A field that is added to a class is drawn without a word here.
"""

import typing

from hypothesis import strategies as st

from exudyn_crawler import Case, CaseFile, SphereContact, StepProfile
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import Outputs
from exudyn_crawler.settings.fields import allows_none, key_paths, models_of, named_values
from exudyn_crawler.settings.parameters import Parameters
from meshes import SHOE_SIZES

# no lone surrogates: they are no text that a file could hold
TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
BASES = (
    Case.translation(),
    Case.turning(),
    Case.stress(),
    Case.translation().with_(contact=SphereContact.oil_sand()),
)


def changed_value(value, annotation):
    """Strategy of values for a field that has a value: near it, so that many pass the checks."""
    if typing.get_origin(annotation) is typing.Literal:
        return st.sampled_from(typing.get_args(annotation))
    if value is None:
        return st.none()
    if isinstance(value, bool):
        return st.booleans()
    if isinstance(value, int):
        return st.integers(value, value + 3)
    if isinstance(value, float):
        near = st.floats(0.9, 1.1).map(lambda factor: value * factor)
        return near | st.floats(0.0, 1.0) | st.just(value)
    if isinstance(value, str):
        return TEXT
    if isinstance(value, tuple):
        whole = st.tuples(*(changed_value(one, None) for one in value))
        numbers = all(isinstance(one, int | float) for one in value) and len(value) > 1
        # rising numbers stay so
        rising = numbers and list(value) == sorted(set(value))
        return whole.map(lambda one: tuple(sorted(set(one)))) if rising else whole
    if isinstance(value, Parameters):
        others = [kind for kind in models_of(annotation) if kind is not type(value)]
        made = [make() for kind in others for make in named_values(kind).values()]
        return st.sampled_from([value, *made]).flatmap(changed)
    raise AssertionError(f"no strategy for {value!r}")


@st.composite
def changed(draw, base):
    """Copy of a parameter object with some fields changed; the object itself where they do not fit."""
    names = draw(st.lists(st.sampled_from(sorted(type(base).model_fields)), unique=True, max_size=4))
    new = base
    for name in names:
        field = type(base).model_fields[name]
        value = getattr(base, name)
        # a mesh has to be there to be read
        strategy = st.sampled_from(SHOE_SIZES) if name == "mesh" else changed_value(value, field.annotation)
        if allows_none(field.annotation) and StepProfile not in models_of(field.annotation):
            strategy |= st.none()
        try:
            new = new.with_(**{name: draw(strategy)})
        except ParameterError:
            continue
    return new


@st.composite
def case_files(draw):
    """Case files of every kind."""
    case = draw(changed(draw(st.sampled_from(BASES))))
    outputs = draw(changed(Outputs()) | changed(Outputs(shoes=(1, 2), picture_times=(0.0, 1e-7))))
    duration = draw(st.floats(1e-6, 20.0))
    try:
        return CaseFile(case=case, duration=duration, outputs=outputs)
    except ParameterError:
        return CaseFile(case=case, duration=1e-6)


NAMES = sorted({name for path in key_paths(CaseFile) for name in path.split(".")} | {"base", "wrong"})
PLAIN = (
    st.none().map(lambda _none: "none")
    | st.booleans()
    | st.integers()
    | st.floats()
    | TEXT
    | st.datetimes()
    | st.sampled_from(
        ["translation", "stress", "ph4100c", "coarse", "pitch", "oil_sand", "spheres", "general"]
    )
)
TOML = st.dictionaries(
    st.sampled_from(NAMES) | TEXT,
    st.recursive(
        PLAIN,
        lambda inner: (
            st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(NAMES), inner, max_size=4)
        ),
        max_leaves=12,
    ),
    max_size=8,
)
"""Tables of right and wrong names with right and wrong values."""
