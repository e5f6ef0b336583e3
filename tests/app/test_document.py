"""The case file that is worked on: form and text are one, and what is refused stays beside them."""

import tomllib

import pytest

pytest.importorskip("nicegui", reason="the extra `app` is not installed")

from exudyn_crawler.app.document import Document
from exudyn_crawler.case import Case
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.machines import CaseFile, duties, read_case, write_case
from exudyn_crawler.machines.case_file import typed_text
from exudyn_crawler.machines.case_files import typed_value
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.constraints import choices, presets, range_words

WEIGHT = "datasheet.operating_weight"


@pytest.fixture
def document(tmp_path):
    return Document(tmp_path)


def test_what_is_typed_is_the_file_and_its_comments_stay(document):
    assert document.type(WEIGHT, "36.5 t")
    assert document.case_file.datasheet.operating_weight == 36.5e3
    assert 'operating_weight = "36.5 t"' in document.text
    assert "# triple" in document.text
    assert document.type("duration", "2 s")
    assert document.type("gear.idler.sag", "25 mm")
    assert document.type("terrain.grade", "10 %")
    path = document.save("mine")
    assert read_case(path) == document.case_file
    assert document.case_file.case.terrain.grade == 0.1
    assert document.saved == document.text


def test_values_that_follow_change_with_what_they_follow_from(document):
    before = document.case_file.case
    assert document.type("datasheet.shoes", "47")
    after = document.case_file.case
    assert after.track.shoe_count == 94
    assert after.track.pitch != before.track.pitch
    assert document.entries()["track.pitch"].value == after.track.pitch
    assert document.origins()["track.pitch"].origin == "derived"


def test_what_is_refused_is_said_in_the_words_of_the_command_and_changes_nothing(document):
    text = document.text
    assert not document.type(WEIGHT, "-3 kg")
    assert document.text == text
    (line,) = document.errors[WEIGHT]
    path = document.folder / "mine.toml"
    path.write_text(text)
    with pytest.raises(CaseFileError) as told:
        read_case(path, [f"{WEIGHT}=-3 kg"])
    assert told.value.errors == [line]
    document.forget(WEIGHT)
    assert document.errors == {}


def test_values_that_must_change_together_are_typed_one_after_the_other(document):
    assert not document.type("datasheet.width_over_shoes", "3390 mm")
    assert "datasheet.width_over_shoes" in document.errors
    assert document.type("datasheet.gauge", "")
    assert document.errors == {}
    sheet = document.case_file.datasheet
    assert (sheet.gauge, sheet.width_over_shoes) == (None, 3.39)


def test_a_later_fitting_value_does_not_wait_for_a_refused_one(document):
    assert not document.type(WEIGHT, "-3 kg")
    assert document.type("duration", "3 s")
    assert document.case_file.duration == 3.0
    assert list(document.errors) == [WEIGHT]


def test_every_value_reads_back_as_the_form_shows_it(document, tmp_path):
    document.load(write_case(CaseFile(case=Case.shovel(), duration=1.0), tmp_path / "shovel.toml"))
    entries = [entry for entry in document.entries().values() if not fields.is_table(entry.value)]
    numbers = [entry for entry in entries if fields.is_number(entry.value)]
    assert len(numbers) > 80
    typed = {entry.path: typed_value(typed_text(entry)) for entry in numbers}
    assert document.change(typed), document.errors
    again = document.entries()
    for entry in numbers:
        assert again[entry.path].value == pytest.approx(entry.value, rel=1e-7)


def test_items_of_a_list_that_the_file_does_not_have_are_taken_from_the_case(document):
    assert document.type("gear.rollers[0]", "-1.6 m")
    assert document.case_file.case.gear.rollers[0] == -1.6
    assert len(tomllib.loads(document.text)["gear"]["rollers"]) == 8
    part = {"model": "stone", "x": 6.0, "y": 0.0, "height": 0.1, "flank": 0.3}
    assert document.change({"terrain.relief.parts[0]": part}), document.errors
    assert document.type("terrain.relief.parts[0].height", "20 cm")
    assert document.case_file.case.terrain.relief.parts[0].height == 0.2
    assert document.change({"terrain.relief.parts[0]": None})
    assert document.case_file.case.terrain.is_even


def test_a_text_is_taken_whole_or_refused(document):
    text = document.text
    with pytest.raises(CaseFileError, match="not TOML"):
        document.take_text("[[")
    with pytest.raises(CaseFileError, match="unknown key"):
        document.take_text(text.replace("shoe_width", "shoe_wide"))
    assert document.text == text
    document.take_text(text.replace("duration = 5.0", "duration = 4.0"))
    assert document.case_file.duration == 4.0


def test_the_file_of_another_case_is_not_written_over(document):
    document.save("mine")
    assert document.type("duration", "1 s")
    path = document.save("mine")
    assert path.read_text() == document.text
    document.start_from("cat315c")
    with pytest.raises(FileExistsError):
        document.save("mine")
    assert document.saved != document.text
    document.load(path)
    path.write_text("# another program")
    with pytest.raises(FileExistsError):
        document.save("mine")


def test_fields_know_their_words_bounds_and_ready_values(document):
    entries = document.entries()
    assert choices(entries["datasheet.travel"].field.annotation) == ["straight", "backward", "on the spot"]
    assert choices(entries["outputs.page"].field.annotation) == ["true", "false"]
    assert choices(entries["gear.idler.sag"].field.annotation) == []
    assert range_words(entries[WEIGHT].field) == "1000 kg to 2e6 kg as a rule"
    assert "at most 100" in range_words(entries["gravity"].field) or "9.7" in range_words(
        entries["gravity"].field
    )
    law = presets(entries["drive"].field)
    assert law["turning"] == {"base": "turning"}


PICKED = {name: values for names in duties.lists().values() for name, values in names.items()}


@pytest.mark.parametrize("values", PICKED.values(), ids=PICKED)
def test_everything_that_is_picked_for_ground_and_duty_is_taken(document, values):
    text = document.text
    changes = values(document.case_file)
    assert document.change(changes), document.errors
    assert document.text != text or set(changes.values()) == {None}


def test_a_machine_that_digs_stands_and_travels_again(document):
    assert document.change(PICKED[duties.DIG](document.case_file))
    case_file = document.case_file
    assert case_file.duration == case_file.case.machine.phases[-1].end
    assert case_file.case.drive.speed.integral(case_file.duration) == 0.0
    assert document.change(PICKED["propel backward"](document.case_file))
    assert document.case_file.case.machine is None
    assert document.case_file.case.drive.speed.integral(5.0) < 0.0


def test_a_file_that_is_dropped_again_after_a_correction_is_read_anew(document):
    wrong = document.text.replace('operating_weight = "', 'operating_weight = "-').encode()
    right = document.text.encode()
    path = document.store("mine.toml", wrong)
    with pytest.raises(CaseFileError):
        document.load(path)
    assert document.store("mine.toml", right) == path
    assert path.read_bytes() == right
    document.load(path)
    assert document.name == "mine"


def test_a_dropped_file_takes_the_place_of_no_other_one(document):
    own = document.folder / "mine.toml"
    own.write_text("duration = 1.0\n")
    content = document.text.encode()
    assert document.store("../mine.toml", content) == document.folder / "mine_2.toml"
    assert own.read_text() == "duration = 1.0\n"
    # the same content is the same file
    assert document.store("mine_2.toml", content) == document.folder / "mine_2.toml"
    document.load(document.folder / "mine_2.toml")
    document.type("duration", "2 s")
    document.save("mine_2")
    assert document.store("mine_2.toml", content) == document.folder / "mine_2_2.toml"
    assert read_case(document.folder / "mine_2.toml").duration == 2.0
