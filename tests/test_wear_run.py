"""Wear forecasts into a folder, in Python and by the command."""

import pandas as pd
import pytest
from typer.testing import CliRunner

from exudyn_crawler import Case, read_wear, wear
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.results.wear.ledger import inputs_ledger
from exudyn_crawler.views.pages import signed
from exudyn_crawler.views.wear import file_name
from exudyn_crawler.wear_run import INPUTS, OF_INSPECTIONS, WEAR_PAGE

PLAN = """
inspections = "seen.csv"

[[parts]]
part = "pitch"
new = "216 mm"

[[parts]]
part = "roller"
new = "180 mm"
limit = "165 mm"
"""
SEEN = """date,machine hours,propel hours,part,side,place,value in mm,links
2024-02-10,800,80,pitch,right,,866.1,4
2024-02-10,800,80,pitch,left,,866.5,4
2024-07-02,1600,160,pitch,right,,868.6,4
2024-07-02,1600,160,pitch,left,,869.3,4
2024-12-12,2400,240,pitch,right,,871.2,4
2024-12-12,2400,240,pitch,left,,872.6,4
2024-12-12,2400,240,roller,right,3,178.1,
"""


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "seen.csv").write_text(SEEN)
    (tmp_path / "mine.toml").write_text(PLAN)
    return tmp_path / "mine.toml"


def test_inspections_alone_give_residual_hours_and_a_page(plan, tmp_path):
    found = wear(plan, tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *OF_INSPECTIONS,
        INPUTS,
        WEAR_PAGE,
        file_name("percent worn"),
        signed.STORED,
    }
    table = pd.read_csv(tmp_path / "out" / "due.csv")
    assert table["part"].tolist() == ["left pitch", "right pitch", "right roller 3"]
    left = table.iloc[0]
    # 8.6 of the 3.78 mm x 4 at which pins and bushes are turned
    assert left["worn in %"] == pytest.approx(100.0 * 8.6 / (4.0 * 216.0 * 0.0175), rel=0.03)
    assert left["at least"] < left["machine hours left"] < left["at most"]
    # a tenth of the machine hours is travel
    assert left["machine hours left"] == pytest.approx(10.0 * (left["life in propel hours"] - 240.0))
    assert "turn pins and bushes in" in found.lines[0]
    assert "no band from one reading" not in found.lines[0]
    page = (tmp_path / "out" / "wear.html").read_text()
    assert "What is due, and when" in page
    with pytest.raises(FileExistsError):
        wear(plan, tmp_path / "out")


def test_the_report_to_sign_has_the_table_of_the_page_and_the_files(plan, tmp_path):
    found = wear(plan, tmp_path / "out")
    report = signed.stored(tmp_path / "out")
    assert report.lines == tuple(found.lines)
    assert [row[0] for row in report.answers.rows] == found.forecast.table["part"].tolist()
    files = [name.rpartition("/")[2] for name, _ in report.checksums]
    assert files == ["mine.toml", "seen.csv", signed.ALL_VALUES]
    assert dict(report.given)["parts[1].new"] == "0.18 m"
    values = report.checksums[2]
    plan.write_text(plan.read_text().replace("165 mm", "164 mm"))
    wear(plan, tmp_path / "out", overwrite=True)
    assert signed.stored(tmp_path / "out").checksums[2] != values


def test_the_ledger_has_units_of_the_fields_and_names_who_gives_the_propel_share(plan):
    found = wear(plan)
    case = Case.closed()
    inputs = inputs_ledger(found.plan, case, found.forecast.inspections)
    units = {path: inputs[path].unit for path in ("pin.radius", "sweep", "pin.state", "grouser_measure")}
    assert units == {"pin.radius": "m", "sweep": "rad", "pin.state": "", "grouser_measure": ""}
    assert inputs["pin.radius"].value == pytest.approx(case.track.pin.radius_at(case.track.pitch))
    share = inputs["propel_share"]
    assert (share.value, share.origin) == (pytest.approx(0.1), "derived")
    assert found.forecast.per_machine_hour == pytest.approx(0.1)

    stated = inputs_ledger(found.plan.with_(propel_share=0.2), case, found.forecast.inspections)
    assert (stated["propel_share"].value, stated["propel_share"].origin) == (0.2, "given")

    lines = SEEN.splitlines()
    uncounted = [",".join((*line.split(",")[:2], "", *line.split(",")[3:])) for line in lines[1:]]
    (plan.parent / "seen.csv").write_text("\n".join([lines[0], *uncounted]))
    unknown = wear(plan)
    assert unknown.inputs["propel_share"].value is None
    assert unknown.inputs["propel_share"].origin == "assumed"
    assert unknown.forecast.per_machine_hour == 1.0


def test_a_stated_error_of_readings_gives_the_bands_of_each_run(plan):
    hours = ("75,5", "100,60", "175,65")
    lines = [line + f",{hours[min(number // 2, 2)]}" for number, line in enumerate(SEEN.splitlines()[1:7])]
    (plan.parent / "seen.csv").write_text("\n".join([SEEN.splitlines()[0] + ",hours a,hours b", *lines]))
    plan.write_text(
        f"by_run = true\n{PLAN}".replace('new = "216 mm"', 'new = "216 mm"\nreading_error = "0.2 mm"')
    )
    table = wear(plan).forecast.table
    assert table["scatter in %"].to_numpy() == pytest.approx([100.0 * 0.2 / (216.0 * 0.0175)] * 2, rel=3e-3)
    bands = table["life at most"] - table["life at least"]
    plan.write_text(plan.read_text().replace("0.2 mm", "0.1 mm"))
    narrow = wear(plan).forecast.table
    assert (narrow["life at most"] - narrow["life at least"] < 0.6 * bands).all()


def test_a_plan_without_what_is_needed_is_refused(plan):
    plan.write_text(PLAN.replace('limit = "165 mm"', ""))
    with pytest.raises(CaseFileError, match="limit must be given for a part 'roller': makers differ"):
        read_wear(plan)
    plan.write_text(PLAN.partition('[[parts]]\npart = "roller"')[0])
    with pytest.raises(ValueError, match="parts must have a table for 'roller', which row 7"):
        wear(plan)
    plan.write_text(PLAN.replace("216 mm", "220 mm").replace("[[parts]]", '[[parts]]\nlimit = "219 mm"', 1))
    with pytest.raises(CaseFileError, match=r"limit must be above new = 0\.22 m"):
        read_wear(plan)


def test_the_command_prints_what_is_due_first(plan, tmp_path):
    from exudyn_crawler.cli import commands, looking

    assert looking.wear
    result = CliRunner().invoke(commands.app, ["wear", str(plan), "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "left pitch" in result.output
    assert "wear.html" in result.output
