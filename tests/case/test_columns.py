"""Text tables as programs write them: coding, separators, marks in numbers, units, counted rows."""

import pytest

from exudyn_crawler.case.parameters import columns

PLAIN = "time [s],sum [kN]\n0.5,5023.0\n1.0,5130.25\n"


def table(folder, text, coding="utf-8"):
    path = folder / "table.csv"
    path.write_bytes(text.encode(coding))
    return columns.read_table(path)


@pytest.mark.parametrize("coding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.replace(",", ";"),
        "sep=;\n" + PLAIN.replace(",", ";"),
        "SEP=\t\r\n" + PLAIN.replace(",", "\t"),
        "time [s];sum [kN]\n0,5;5023,0\n1,0;5130,25\n",
        "time [s];sum [kN]\n0,5;5.023,0\n1,0;5.130,25\n",
        'time [s],sum [kN]\n0.5,"5,023.0"\n1.0,"5,130.25"\n',
        "time [s];sum [kN]\n0.5;5 023.0\n1.0;5'130.25\n",
        "time [s];sum [kN]\n0.5;5\u202f023.0\n1.0;5\u00a0130.25\n",
        ",time,sum\n,s,kN\n0,0.5,5023.0\n1,1.0,5130.25\n",
        "Time_s_,sum_kN_\n0.5,5023.0\n1.0,5130.25\n",
    ],
)
def test_a_table_is_the_same_however_it_is_written(tmp_path, text, coding):
    heads, rows = table(tmp_path, text, coding)
    assert [columns.head_parts(head) for head in heads] == [("time", "s"), ("sum", "kN")]
    assert [[float(cell) for cell in row] for row in rows] == [[0.5, 5023.0], [1.0, 5130.25]]


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("a;b\n0;1.234.567\n1;5.130\n", [1234567.0, 5130.0]),  # thousands twice
        ("a;b\n0,5;5.023\n1;5.130\n", [5023.0, 5130.0]),  # decimals in the other column
        ("a;b\n0.125;5.023\n1;5.130\n", [5.023, 5.130]),  # no thousands begin with a zero
        ("a;b\n0;5.023\n1;5130.25\n", [5.023, 5130.25]),
        ("a;b\n0;1.234e3\n1;2.345\n", [1234.0, 2.345]),
        ("a,b\n0,5.023\n1,5.130\n", [5.023, 5.130]),  # between commas a point is that of decimals
        ("a\tb\n0\t5023\n1\t-5130\n", [5023.0, -5130.0]),
        ("a;b\n0;5023\n1;\u22125130\n", [5023.0, -5130.0]),
        ("a;b\n03.05.24;0,5\n04.05.24;1,25\n", [0.5, 1.25]),  # dates are no numbers
    ],
)
def test_one_number_says_what_the_marks_of_all_mean(tmp_path, text, numbers):
    _, rows = table(tmp_path, text)
    assert [float(row[1]) for row in rows] == numbers


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("a;b\n0;5.023\n5;5.130\n10;5.460\n", "5.023"),
        ("a\tb\n0\t12,345\n5\t5\n", "12,345"),
        ('a,b\n0,"5,023"\n5,"5,130"\n', "5,023"),
    ],
)
def test_what_may_be_thousands_is_asked(tmp_path, text, cell):
    value = float(cell.replace(",", "."))
    with pytest.raises(ValueError, match=rf"is {cell} in row 1 {value} or {1e3 * value:g}\?"):
        table(tmp_path, text)


def test_a_column_that_counts_rows_is_left_out_and_no_other(tmp_path):
    for head in ("", "index", "Unnamed: 0", "#", "No."):
        text = f"{head},time [s]\n7,0.5\n8,0.7\n"
        assert table(tmp_path, text if head != "#" else f'"#",{text[2:]}')[0] == ["time [s]"]
    assert table(tmp_path, "index,time [s]\n7,0.5\n7,0.7\n")[0] == ["index", "time [s]"]


def test_labels_are_no_units(tmp_path):
    heads, rows = table(tmp_path, "test,time\nm,1\ns,2\n")
    assert heads == ["test", "time"]
    assert len(rows) == 2


def test_a_workbook_is_told(tmp_path):
    (tmp_path / "table.csv").write_bytes(b"PK\x03\x04\xff\xd8\xff")
    with pytest.raises(
        ValueError, match=r"must be a text in UTF-8 or UTF-16: .*workbook: save the sheet as CSV"
    ):
        columns.read_table(tmp_path / "table.csv")


def test_kips_are_thousands_of_pounds():
    assert columns.factor_of("kip", "N") == columns.factor_of("klbf", "N") == pytest.approx(4448.2216152605)


def test_swapped_columns_are_asked_about(tmp_path):
    (tmp_path / "table.csv").write_text("sinkage in kPa,pressure in mm\n1,2\n")
    with pytest.raises(ValueError, match="are the columns 'sinkage' and 'pressure' swapped"):
        columns.read_columns(tmp_path / "table.csv", {"sinkage": "m", "pressure": "Pa"})
