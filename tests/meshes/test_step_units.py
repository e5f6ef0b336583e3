"""Units of length that STEP files name."""

import pytest

from meshes.recognition.step_units import units_of

HEAD = (
    "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('in #7 = LENGTH_UNIT() SI_UNIT($,.METRE.);'),'2;1');\n"
    "ENDSEC;\nDATA;\n"
)
CONTEXT = (
    "#1=(GEOMETRIC_REPRESENTATION_CONTEXT(3)\nGLOBAL_UNIT_ASSIGNED_CONTEXT((#2,#3,#4))\n"
    "REPRESENTATION_CONTEXT('','3D'));\n#3=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n"
    "#4=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n"
)
CM = "( LENGTH_UNIT() NAMED_UNIT(*)\n SI_UNIT(.CENTI.,.METRE.) );\n"
INCH = (
    "#2 = ( CONVERSION_BASED_UNIT('INCH',#5) LENGTH_UNIT() NAMED_UNIT(#7) );\n"
    "#5 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(2.54),#6);\n"
    f"#6 = {CM}#7 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
)


@pytest.mark.parametrize(
    ("text", "units"),
    [
        (CONTEXT + "#2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n", [("mm", 1e-3)]),
        (CONTEXT + f"#2 = {CM}", [("cm", 1e-2)]),
        (CONTEXT + "#2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));\n", [("m", 1.0)]),
        (CONTEXT + "#2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MICRO.,.METRE.));\n", [("micrometre", 1e-6)]),
        (CONTEXT + INCH, [("inch", 0.0254)]),
        (CONTEXT + INCH.replace("INCH", "FOOT").replace("2.54", "30.48"), [("foot", 0.3048)]),
        # a part of an assembly in another unit
        (
            CONTEXT + f"#2 = {CM}#9 = ( GLOBAL_UNIT_ASSIGNED_CONTEXT((#8)) );\n"
            "#8=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n",
            [("cm", 1e-2), ("mm", 1e-3)],
        ),
        # units that no geometry is in
        (f"#2 = {CM}", []),
        (CONTEXT, []),
        ("", []),
    ],
)
def test_the_unit_of_the_geometry_is_read(tmp_path, text, units):
    path = tmp_path / "shoe.step"
    path.write_text(f"{HEAD}{text}ENDSEC;\nEND-ISO-10303-21;\n")
    found = units_of(path)
    assert [unit.name for unit in found] == [name for name, _ in units]
    assert [unit.metres for unit in found] == pytest.approx([metres for _, metres in units])
