"""The shoe: mass, underside, load, and the rails that rollers roll on."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray
from pydantic import Field, model_validator

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters.base import Parameters, Place, quantity


class Rails(Parameters):
    """Two level rails of a shoe, in its frame."""

    rear: Place = quantity("m", "x of the rear ends", plausible=(-1.0, 0.0))
    front: Place = quantity("m", "x of the front ends", plausible=(0.0, 1.0))
    right: Place = quantity("m", "y of the middle of the right rail", plausible=(-1.5, 0.0))
    left: Place = quantity("m", "y of the middle of the left rail", plausible=(0.0, 1.5))
    width: float = quantity("m", "width of a rail", plausible=(0.05, 1.0), ge=1e-3, le=100)
    height: Place = quantity("m", "z of their tops", plausible=(0.0, 1.0))

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.front <= self.rear:
            raise ValueError(f"front must be greater than rear = {self.rear}, got {self.front}")
        if self.left - self.right < self.width:
            raise ValueError(
                f"left and right must be apart by the width {self.width} at least, "
                f"got {self.right} and {self.left}: the rails overlap"
            )
        return self

    @classmethod
    def ph4100c(cls) -> Self:
        """Rails of the shoe in `meshes/`."""
        return cls(**ph4100c.RAILS)

    @property
    def middles(self) -> tuple[float, float]:
        """Y of the middles of the right and of the left rail, m."""
        return self.right, self.left


if TYPE_CHECKING:
    from fem import Mesh

Moment = Annotated[float, Ge(-1e12), Le(1e12)]
"""Moment of inertia, kg m2."""

STEEL_DENSITY: float = ph4100c.FLEXIBLE_SHOES["density"]
"""kg/m3."""
ORIGIN_TOLERANCE = 0.01
"""m, between the origin of a mesh and its COM."""


class Shoe(Parameters):
    """Rigid crawler shoe.

    Places are given in the shoe's frame: origin at the COM, x in the propel direction, y lateral, z up.
    """

    mass: float = quantity("kg", "mass", plausible=(50.0, 2e4), ge=0.1, le=1e7)
    inertia: tuple[Moment, Moment, Moment, Moment, Moment, Moment] = quantity(
        "kg m2", "Ixx, Iyy, Izz, Iyz, Ixz, Ixy about the COM (tensor components)"
    )
    com_height: float = quantity(
        "m", "height of the COM above the underside", plausible=(0.02, 1.0), ge=1e-3, le=100
    )
    length: float = quantity("m", "length of the flat underside in x", plausible=(0.1, 2.0), ge=1e-3, le=100)
    width: float = quantity("m", "width of the flat underside in y", plausible=(0.2, 6.0), ge=1e-3, le=100)
    underside_center: tuple[Place, Place] = quantity(
        "m", "x and y of the underside's centre in the shoe's frame", plausible=(-1.0, 1.0)
    )
    load_point: tuple[Place, Place, Place] = quantity(
        "m",
        "centroid of the top face, where the machine load acts, in the shoe's frame",
        plausible=(-3.0, 3.0),
    )

    rails: Rails | None = Field(default=None, description="rails that rollers roll on")

    @model_validator(mode="after")
    def _check(self) -> Self:
        principal = np.linalg.eigvalsh(self.inertia_tensor)
        if principal[0] <= 0.0 or principal[2] > principal[0] + principal[1]:
            raise ValueError(
                f"inertia must be that of a body (principal moments positive, none above the sum of "
                f"the other two), got principal moments {principal.tolist()}"
            )
        return self

    @classmethod
    def ph4100c(cls) -> Self:
        """Shoe of the P&H 4100C BOSS in the rigid studies.

        Mass and COM height are the papers'. They print no inertia and no outline of the underside (CAD): both
        are those of the shoe in `meshes/`.
        """
        return cls(**ph4100c.SHOE)

    @classmethod
    def from_mesh(
        cls,
        mesh: "str | Mesh",
        density: float = STEEL_DENSITY,
        load_surface: str = "whole top",
    ) -> Self:
        """Shoe as its mesh has it: mass, inertia, underside and load point.

        Parameters
        ----------
        mesh : str or fem.Mesh
            In shoe axes, m: coarse, study or fine, the path of a file, or a mesh. It needs the surfaces
            "underside" and the one that is loaded.
        density : float
            kg/m3.
        load_surface : str
            Surface that the machine load is spread over, as of `FlexibleShoes`.

        Raises
        ------
        FileNotFoundError, fem.MeshError
            If there is no such mesh.
        ValueError
            If the mesh is larger than any shoe, lacks one of the surfaces, or its origin is not its COM.
        """
        # a case without a mesh need not wait for finite elements
        from fem import ElasticBody
        from meshes import STEEL, mesh_named, with_load_surfaces
        from meshes.checks import check_extent, check_surfaces
        from meshes.rails import rail_outline

        found = mesh_named(mesh) if isinstance(mesh, str) else with_load_surfaces(mesh)
        name = mesh if isinstance(mesh, str) else ""
        check_extent(found, name)
        check_surfaces(found, load_surface, name)
        body = ElasticBody(found, replace(STEEL, density=density))
        off = body.center_of_mass
        if np.abs(off).max() > ORIGIN_TOLERANCE:
            raise ValueError(
                f"mesh must have its origin at its COM within {ORIGIN_TOLERANCE} m, its COM is at "
                f"{off.round(4).tolist()} m"
            )
        under = found.nodes[found.nodes_of("underside")]
        low, high = under.min(axis=0), under.max(axis=0)
        weights = body.surface_weights(load_surface)
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia.tolist()
        return cls(
            mass=body.mass,
            inertia=(xx, yy, zz, yz, xz, xy),
            com_height=-low[2],
            length=high[0] - low[0],
            width=high[1] - low[1],
            underside_center=tuple((0.5 * (low + high)[:2]).tolist()),
            load_point=tuple((weights @ found.nodes / weights.sum()).tolist()),
            rails=Rails(**rail_outline(found)._asdict()) if "roller path" in found.surfaces else None,
        )

    def of_mass(self, mass: float) -> Self:
        """Same shape of another density (kg): its inertia goes with the mass."""
        ratio = mass / self.mass
        return self.with_(mass=mass, inertia=tuple(ratio * value for value in self.inertia))

    @property
    def inertia_tensor(self) -> NDArray:
        """Inertia tensor about the COM, array (3, 3), kg m2."""
        xx, yy, zz, yz, xz, xy = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    @property
    def footprint(self) -> NDArray:
        """Underside in the shoe's frame: least and greatest x, least and greatest y, z; m."""
        cx, cy = self.underside_center
        return np.array(
            [
                cx - 0.5 * self.length,
                cx + 0.5 * self.length,
                cy - 0.5 * self.width,
                cy + 0.5 * self.width,
                -self.com_height,
            ]
        )
