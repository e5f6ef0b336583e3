"""Contents of files that users write or other programs do, valid ones, which the tests change."""

LAW = """model = "bekker"
base = "lete_sand"
k_c = 102e3
k_phi = 5.301e6
exponent = 0.793
cohesion = 1.3e3
friction_angle = 31.1
"""
MAP_CASE = """base = "rolled"
duration = 0.02
[terrain]
model = "cells"
origin = [5.0, 3.0]
length = 25.0
width = 13.0
[terrain.relief.measured]
file = "{file}"
smoothing = 0.5
[contact]
model = "cells"
[contact.law]
model = "bekker"
base = "lete_sand"
"""
PLAIN_MAP = MAP_CASE.replace("smoothing", "origin = [3.0, 1.0]\nspacing = 0.5\nsmoothing")
LOADS_CASE = 'base = "translation"\nduration = 0.02\n[loads]\nfile = "{file}"\n'
RUTS_CASE = MAP_CASE.replace("[terrain.relief.measured]\n", "").replace("smoothing = 0.5\n", "")
RUTS_CASE = RUTS_CASE.replace('file = "{file}"', 'ruts = "{file}"')
LAW_CASE = """base = "rolled"
duration = 0.02
[terrain]
model = "cells"
origin = [5.0, 3.0]
length = 25.0
width = 13.0
[contact]
model = "cells"
[contact.law]
file = "{file}"
"""
DUTY = """name = "digging"
plane_nodes = 0
survivals = [0.5, 0.975]
changes_an_hour = 4
[material]
base = "cast_nicrmo"
[[stages]]
name = "new"
hours = 12500
[[runs]]
name = "pass"
folder = "run.nc"
stage = "new"
share = 0.07
[[runs]]
name = "dig"
folder = "run.nc"
stage = "new"
an_hour = 23.3
"""
SCATTER = """duty = "duty.toml"
runs = 20
seed = 3
[[vary]]
key = "survivals[0]"
name = "strength"
low = 0.001
high = 0.999
[[vary]]
key = "material.casting_factor"
low = 1.1
high = 1.4
[[vary]]
key = "runs[1].an_hour"
factor = true
low = 0.5
high = 2.0
scale = "log"
distribution = "normal"
[fleet]
shoes = 78
hours_a_year = 6000.0
rebuild = 25000.0
"""
CHECK = """mesh = "coarse"
hours = 25000
[material]
base = "cast_nicrmo"
[[cases]]
name = "two stones"
treads = [{ side = "left", force = 574e3, width = 0.06 }, { side = "right", force = 574e3 }]
[cases.ground]
stiffness = 1e9
parts = [{ low = [-0.3, 1.2], high = [0.0, 1.5], round = true, height = 0.05, stiffness = 1e10 }]
[[cases]]
name = "pinched"
treads = [{ side = "left", force = 574e3 }, { side = "right", force = 574e3 }]
[cases.ground]
stiffness = 1e9
"""
SWEEP = """design = "latin_hypercube"
runs = 8
seed = 3
[case]
base = "translation"
duration = 0.5
[[vary]]
key = "terrain.spring_stiffness"
low = 5e6
high = 80e6
scale = "log"
[[vary]]
key = ["contact.static_friction", "contact.dynamic_friction"]
name = "friction"
factor = true
low = 0.5
high = 1.5
[[answers]]
quantity = "joint_force"
statistic = "mean"
of = [12]
start = 0.2
"""
PHASES = """[[phases]]
name = "propel"
end = 15.0
loads = 386.4e3
[[phases]]
name = "dig"
end = 20.0
loads = 420e3
side_shift = 0.05
"""
ASSESSMENT = """machine = "shovel"
name = "P&H 4100C BOSS"
mesh = "none"
hours = 25000.0
rated_part = 0.75
[work]
payload = 90724.8
reach = 17.0
least_reach = 14.0
height = 9.0
digging = [-4e5, -4e5]
slew_rate = 0.3
grade = 0.1
side_slope = 0.05
wind_area = 250.0
wind_height = 8.0
[ground]
name = "dense gravel"
allowed_pressure = 4e5
friction = 0.3
rolling = 0.05
[drive]
torque = 1.5e6
efficiency = 0.9
power = 1.2e6
rest_tension = 2.8e5
breaking_tension = 9e6
[pins]
diameter = 0.1
inner = 0.2
outer = 0.1
gap = 0.005
tensile_strength = 800e6
yield_strength = 550e6
"""
LOAD_CASES_OF = (
    'machine = "shovel"\nmesh = "none"\nload_cases = "{file}"\n[work]\npayload = 9e4\nreach = 17.0\n'
)
TABLE = "time [s],load [kN],side shift [mm]\n" + "".join(f"{t / 2},{386 + t},{t}\n" for t in range(20))
MEASURED = "time in s,joint_force 12 x in kN,displacement 13 x in mm\n" + "".join(
    f"{0.002 * t},{0.4 + 0.01 * t},{0.02 * t * t}\n" for t in range(10)
)
GRID = "ncols 60\nnrows 40\nxllcorner 3.0\nyllcorner 1.0\ncellsize 0.5\nNODATA_value -9999\n" + "\n".join(
    " ".join(f"{0.01 * ((row * column) % 7):.3f}" for column in range(60)) for row in range(40)
)
DECK = """*HEADING
a block
*NODE, NSET=ALL
1, 0.0, 0.0, 0.0
2, 1.0, 0.0, 0.0
3, 0.0, 1.0, 0.0
4, 0.0, 0.0, 1.0
5, 1.0, 1.0, 1.0
*ELEMENT, TYPE=C3D4, ELSET=SOLID
1, 1, 2, 3, 4
2, 2, 3, 4, 5
*NSET, NSET=BASE
1, 2, 3
*SURFACE, NAME=TOP, TYPE=ELEMENT
2, S3
"""
NETCDF = """height = "z"
x = "x"
y = "y"
height_unit = "m"
place_unit = "m"
x_first = 3.0
y_first = 1.0
x_step = 0.5
y_step = 0.5
amplitude = 0.03
offset = 0.0
missing = -9999.0
columns = 60
rows = 40
kind = "f8"
"""
"""Text that a NetCDF file or an array is made of."""
