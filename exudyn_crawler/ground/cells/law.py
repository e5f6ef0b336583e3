"""Input and response of a law of the cells, and its compiled code by address.

A law is one file of `laws`: a named tuple of its constants, two compiled functions (`prepare`, `respond`) and
a class of parameters. The kernel is compiled once for each law; the type of the constants identifies the law.
The equations call it by its address, so that neither they nor their cached code depend on a law. They are not
compiled again for another law, and a law of another package needs no line here.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload
from scipy.optimize import brentq

from exudyn_crawler.case.parameters import terrain
from exudyn_crawler.ground.frames import Vector
from exudyn_crawler.settings import parameters
from fem.compiling import compiler

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DRAWN = 400e3
"""Greatest pressure (Pa) of drawn curves."""


class Memory(NamedTuple):
    """Memory of a cell: committed, or on trial within a step.

    `deepest` is the greatest sinkage (m) and `pressure` the pressure there (Pa). `shear` is the shear stress
    of the ground in the cell's plane (Pa, global), `mobilized` the mobilized share of the shear strength.
    """

    deepest: float
    pressure: float
    shear: Vector
    mobilized: float


class Probe(NamedTuple):
    """State of a cell under a shoe, as input of a law.

    It has the depth (m) below the cell's first height along its normal, and its rate (m/s). The slip since
    the last accepted step (m) and its velocity (m/s) are vectors in the cell's plane. The committed memory
    follows, and the result of `prepare` for it: the modulus of unloading (Pa/m) and the shear stiffness
    (Pa/m).
    """

    depth: float
    rate: float
    slip: Vector
    slip_velocity: Vector
    memory: Memory
    prepared: tuple[float, float]


class Response(NamedTuple):
    """Response of a law per unit area: the shoe receives ``normal n - shear - drag * slip velocity``."""

    normal: float  # traction, Pa, and its derivatives by depth and rate
    normal_by_depth: float
    normal_by_rate: float
    shear: Vector  # Pa
    tangential_by_depth: Vector  # derivative of shear and drag by the depth
    along: float  # derivative of the shear by a slip in the direction of `direction`, Pa/m
    across: float  # and by one across it
    direction: Vector  # unit vector, or zero where both derivatives are the same
    drag: float  # viscous part, Pa s/m
    memory: Memory  # on trial; a zero shear with the share of fresh ground where there is no contact


class LawKernel(NamedTuple):
    """Compiled side of a law.

    `prepare` computes the values that are constant through a step, `Probe.prepared`. Without `tangents` only
    `normal`, `shear`, `drag` and `memory` of the response are used. A processor computes powers and
    exponentials one at a time. `nearby` therefore asks for a response near the committed memory without them,
    so that several points are computed at once. Where no such response exists the normal traction is NaN, and
    the law is evaluated again; a law may respond all the same.
    """

    constants: Any  # type of the named tuple of numbers (float)
    prepare: Callable  # compiled: (constants, deepest, pressure) -> (float, float)
    respond: Callable  # compiled: (constants, Probe, tangents, nearby) -> Response
    fresh: float  # mobilized share of fresh ground
    forgets: bool  # True if a cell without contact becomes fresh, its sinkage too


class CellLaw(terrain.SoilLaw):
    """Parameters of a law of the cells, with those that all laws have; base of the classes in `laws`."""

    kernel: ClassVar[LawKernel]
    shear_deformation: float = parameters.quantity(
        "m",
        "shear deformation K: slip at which shear of the initial stiffness reaches the strength; 63 %"
        " is mobilized there in soil",
        plausible=(1e-5, 0.1),
        ge=1e-7,
        le=10,
    )
    shear_viscosity: float = parameters.quantity(
        "s",
        "shear viscosity over the shear stiffness of sticking ground",
        ge=0,
        le=10,
        default=2e-3,
    )
    damping: float = parameters.quantity(
        "s/m", "relative growth of the pressure with the sinkage rate", ge=0, le=1e3, default=0.5
    )

    def constants(self, width: float) -> tuple[float, ...]:
        """Return the constants of the compiled law for shoes whose shorter side is `width` (m)."""
        raise NotImplementedError

    def sinkage(self, pressure: float, width: float = 0.65) -> float:
        """Return the sinkage (m) of a plate of `width` (m) on first loading by a pressure (Pa)."""

        def excess(depth: float) -> float:
            return float(self.drive(np.array([depth]), np.zeros(1), width)[0][0]) - pressure

        deep = 0.01
        while excess(deep) < 0.0:
            deep *= 2.0
        return float(brentq(excess, 0.0, deep)) if pressure > 0.0 else 0.0

    def drive(
        self, depths: np.ndarray, slips: np.ndarray, width: float = 0.65
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return pressure and shear stress (Pa) of a cell along a path of accepted steps without rates.

        `depths` and `slips` (steps,) are depth and position along the cell, m; `width` is the shoe's shorter
        side, m.
        """
        constants = self.constants(width)
        nothing = (0.0, 0.0, 0.0)
        memory = Memory(0.0, 0.0, nothing, self.kernel.fresh)
        out = np.zeros((2, len(depths)))
        for step, (depth, slip) in enumerate(zip(depths, np.diff(slips, prepend=slips[0]), strict=True)):
            prepared = self.kernel.prepare(constants, memory.deepest, memory.pressure)
            probe = Probe(float(depth), 0.0, (float(slip), 0.0, 0.0), nothing, memory, prepared)
            answer = self.kernel.respond(constants, probe, False, False)
            # numba gives the numbers of a named tuple back
            memory = Memory(*answer.memory)
            out[:, step] = answer.normal, memory.shear[0]
        return out[0], out[1]

    def draw(self, pressure: "Axes", shear: "Axes") -> None:
        """Draw pressure over sinkage with unloading and reloading, and shear over slip with a reversal.

        Both in kPa over mm.
        """
        high = self.sinkage(DRAWN)
        turns = high * np.array([0.0, 0.6, 0.3, 1.0, 0.5, 0.0])
        depths = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(turns)])
        pressure.plot(1e3 * depths, 1e-3 * self.drive(depths, np.zeros_like(depths))[0])
        pressure.set(xlabel="sinkage, mm", ylabel="pressure, kPa")
        K = self.shear_deformation
        turns = K * np.array([0.0, 3.0, 1.0, 5.0])
        slips = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(turns)])
        for share in (0.25, 0.5, 1.0):
            held, stress = self.drive(np.full_like(slips, share * high), slips)
            shear.plot(1e3 * slips, 1e-3 * stress, label=f"{1e-3 * held[0]:.3g} kPa")
        shear.set(xlabel="slip, mm", ylabel="shear stress, kPa")
        shear.legend(title="pressure")


_KERNELS: dict[type, LawKernel] = {}
"""Compiled sides by the types of their constants, for the compiler."""


def prepare(law, deepest, pressure):
    """Evaluate `LawKernel.prepare` of the law with these constants."""
    return _KERNELS[type(law)].prepare(law, deepest, pressure)


def respond(law, probe, tangents, nearby):
    """Evaluate `LawKernel.respond` of the law with these constants."""
    return _KERNELS[type(law)].respond(law, probe, tangents, nearby)


@overload(prepare, inline="always")
def _prepare(law, deepest, pressure):
    function = _KERNELS[law.instance_class].prepare
    return lambda law, deepest, pressure: function(law, deepest, pressure)


@overload(respond, inline="always")
def _respond(law, probe, tangents, nearby):
    function = _KERNELS[law.instance_class].respond
    return lambda law, probe, tangents, nearby: function(law, probe, tangents, nearby)


def compile_entry(of_law: LawKernel, function: Callable, arguments: tuple) -> int:
    """Return the address of a function compiled for a law; its cache is valid until a source changes."""
    _KERNELS[of_law.constants] = of_law
    # numba caches by this name, and a file of its cache is valid for the sources of one law
    function.__qualname__ = f"{of_law.constants.__module__}.{of_law.constants.__name__}.{function.__name__}"
    wanted = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": False}
    compiled = compiler(of_law.prepare, of_law.respond, **wanted)(function)
    compiled.compile(types.intp(*arguments))
    (code,) = compiled.overloads.values()
    return int(code.library.get_pointer_to_function(code.fndesc.llvm_cfunc_wrapper_name))


@intrinsic
def call_at(_context, address, *arguments):
    """Call a compiled function at an address; arrays, and tuples of arrays, are passed by address."""

    def generate(context, builder, signature, values):
        def handed(kind, value):
            if isinstance(kind, types.Array):
                return context.make_array(kind)(context, builder, value).data
            if isinstance(kind, types.BaseTuple):
                each = cgutils.unpack_tuple(builder, value)
                return cgutils.pack_array(builder, [*map(handed, kind.types, each)])
            return value

        given = [*map(handed, signature.args[1].types, cgutils.unpack_tuple(builder, values[1]))]
        returned = context.get_value_type(types.intp)
        function = ir.FunctionType(returned, [argument.type for argument in given])
        return builder.call(builder.inttoptr(values[0], function.as_pointer()), given)

    return types.intp(address, types.StarArgTuple(arguments)), generate
