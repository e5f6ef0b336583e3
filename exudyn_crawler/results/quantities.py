"""Catalogue of quantities: what the variables of a history and those derived from it are called and measure.

Histories take their attributes from here, figures and tables their units and labels.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import xarray as xr
from numpy.typing import NDArray

Variable = tuple[tuple[str, ...], NDArray, dict[str, str]]
"""Dimensions, values and attributes, as xarray takes a variable."""


@dataclass(frozen=True)
class Quantity:
    """One quantity.

    Attributes
    ----------
    name : str
        Of the variable.
    symbol : str
        Of formulas, in plain text.
    unit : str
        SI; empty for numbers without one.
    long_name : str
        Meaning, with what it counts from and which way it points.
    dimensions : tuple of str
        Of the variable.
    label : str
        Of axes, without the unit.
    """

    name: str
    symbol: str
    unit: str
    long_name: str
    dimensions: tuple[str, ...]
    label: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a variable."""
        return ({"units": self.unit} if self.unit else {}) | {"long_name": self.long_name}


_BODY = ("time", "shoe", "axis")
_UNIT = ("time", "unit")
_LINK = ("time", "joint", "axis")
_PIN = ("time", "joint", "pin", "axis")
_CONTACT = ("time", "contact")
_CONTACT_VECTOR = ("time", "contact", "axis")
_MODE = ("time", "flexible_shoe", "mode")
_NODE = ("shoe", "node")

_HISTORY = (
    Quantity("position", "r", "m", "position of the COM", _BODY, "position"),
    Quantity("velocity", "v", "m/s", "velocity of the COM", _BODY, "velocity"),
    Quantity("acceleration", "a", "m/s2", "acceleration of the COM", _BODY, "acceleration"),
    Quantity("angles", "theta", "rad", "angles of successive rotations about x, y, z", _BODY, "angle"),
    Quantity("angular_velocity", "omega", "rad/s", "angular velocity", _BODY, "angular velocity"),
    Quantity(
        "angular_acceleration", "alpha", "rad/s2", "angular acceleration", _BODY, "angular acceleration"
    ),
    Quantity(
        "joint_force",
        "F_j",
        "N",
        "force of the spherical joint on the rear shoe",
        _LINK,
        "spherical joint reaction",
    ),
    Quantity(
        "joint_torque",
        "T_j",
        "N m",
        "torque of the parallel joint on the rear shoe",
        _LINK,
        "parallel joint torque",
    ),
    Quantity(
        "drive_force",
        "F_d",
        "N",
        "force of the drive on the front shoe along x",
        ("time",),
        "force of the drive along x",
    ),
    Quantity(
        "drive_point",
        "r_d",
        "m",
        "point of the front shoe that the drive moves",
        ("time", "axis"),
        "place of the drive",
    ),
    Quantity(
        "drive_torque",
        "T_d",
        "N m",
        "torque of the turn on the front shoe about its z axis",
        ("time",),
        "torque of the turn about z",
    ),
    Quantity(
        "shoe_load",
        "P",
        "N",
        "machine and dipper load, downward",
        ("time", "shoe"),
        "machine and dipper load",
    ),
    Quantity("unit_heave", "h", "m", "heave of the unit, its springs free", _UNIT, "heave"),
    Quantity("unit_tilt", "phi", "rad", "tilt of the unit, its springs free", _UNIT, "tilt"),
    Quantity("unit_heave_rate", "h'", "m/s", "heave rate of the unit, its springs free", _UNIT, "heave rate"),
    Quantity(
        "unit_tilt_rate", "phi'", "rad/s", "tilt rate of the unit, its springs free", _UNIT, "tilt rate"
    ),
    Quantity(
        "unit_heave_acceleration",
        "h''",
        "m/s2",
        "heave acceleration of the unit, its springs free",
        _UNIT,
        "heave acceleration",
    ),
    Quantity(
        "unit_tilt_acceleration",
        "phi''",
        "rad/s2",
        "tilt acceleration of the unit, its springs free",
        _UNIT,
        "tilt acceleration",
    ),
    Quantity("penetration", "x", "m", "depth at the centroid of the overlap", _CONTACT, "penetration depth"),
    Quantity(
        "penetration_rate", "x'", "m/s", "sinkage velocity at the centroid", _CONTACT, "sinkage velocity"
    ),
    Quantity("area", "A", "m2", "area of the overlap", _CONTACT, "area of contact"),
    Quantity(
        "point",
        "p",
        "m",
        "centroid of the overlap, where the contact acts",
        _CONTACT_VECTOR,
        "point of contact",
    ),
    Quantity("normal_force", "F_N", "N", "normal force on the shoe", _CONTACT_VECTOR, "normal force"),
    Quantity("friction_force", "F_T", "N", "friction force on the shoe", _CONTACT_VECTOR, "friction force"),
    Quantity(
        "slip_velocity",
        "v_s",
        "m/s",
        "slip velocity of the shoe relative to the unit",
        _CONTACT_VECTOR,
        "slip velocity",
    ),
    Quantity(
        "friction_torque", "T_T", "N m", "friction torque on the shoe", _CONTACT_VECTOR, "friction torque"
    ),
    Quantity("modal_coordinate", "q", "kg0.5 m", "modal coordinate", _MODE, "modal coordinate"),
    Quantity("modal_velocity", "q'", "kg0.5 m/s", "rate of the modal coordinate", _MODE, "modal velocity"),
    Quantity(
        "pin_force",
        "F_p",
        "N",
        "force at the pin on the rear shoe; rigid links have one joint",
        _PIN,
        "pin force",
    ),
    Quantity("pin_torque", "T_p", "N m", "torque at the pin on the rear shoe", _PIN, "pin torque"),
)

_DERIVED = (
    Quantity("displacement", "u", "m", "displacement of the COM from equilibrium", _BODY, "displacement"),
    Quantity("contact_force", "F_c", "N", "contact force on the shoe", _CONTACT_VECTOR, "contact force"),
    Quantity(
        "terrain_deformation",
        "d",
        "m",
        "total terrain deformation from equilibrium",
        ("time",),
        "deformation",
    ),
)

_STRESS = (
    Quantity(
        "highest_von_mises",
        "max sigma",
        "Pa",
        "highest von Mises stress",
        ("time", "shoe"),
        "highest von Mises stress",
    ),
    Quantity("highest_node", "n", "", "node of the highest stress", ("time", "shoe"), "node"),
    Quantity("peak_von_mises", "sigma_max", "Pa", "greatest von Mises stress", _NODE, "von Mises stress"),
    Quantity("peak_time", "t_max", "s", "when it occurs", _NODE, "time of the greatest stress"),
    Quantity("least_von_mises", "sigma_min", "Pa", "least von Mises stress", _NODE, "von Mises stress"),
    Quantity(
        "frame_von_mises", "sigma", "Pa", "von Mises stress", ("frame", "shoe", "node"), "von Mises stress"
    ),
    Quantity(
        "frame_displacement",
        "w",
        "m",
        "elastic displacement in the shoe's frame",
        ("frame", "shoe", "node", "axis"),
        "elastic displacement",
    ),
    Quantity(
        "at_load",
        "",
        "",
        "whether the node belongs to an element about the pulled node",
        _NODE,
        "at the load",
    ),
    Quantity("node_position", "X", "m", "place in the shoe's frame", ("node", "axis"), "place"),
    Quantity("triangle", "", "", "nodes of the surface", ("face", "corner"), "node"),
    Quantity("in_spider", "", "", "whether a joint's rigid spider holds the node", ("node",), "in a spider"),
)

QUANTITIES = {quantity.name: quantity for quantity in (*_HISTORY, *_DERIVED, *_STRESS)}
"""Every quantity by the name of its variable."""


def variable(name: str, values: NDArray, without: Iterable[str] = ()) -> Variable:
    """Variable of a dataset with its quantity's dimensions, but for those it goes `without`."""
    quantity = QUANTITIES[name]
    dropped = set(without)
    return tuple(dim for dim in quantity.dimensions if dim not in dropped), values, quantity.attributes


def check_dimensions(dataset: xr.Dataset) -> None:
    """Refuse a dataset of which a variable has not its quantity's dimensions.

    Raises
    ------
    ValueError
        Naming the variable.
    """
    for name, found in dataset.data_vars.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and set(found.dims) != set(quantity.dimensions):
            raise ValueError(f"{name} has dimensions {found.dims}, not {quantity.dimensions}")
