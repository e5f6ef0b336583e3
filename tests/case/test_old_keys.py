"""Keys of earlier releases: what they become, and that one warning says what to write now."""

import json
import tomllib
import warnings

import pytest

from exudyn_crawler import (
    Case,
    CaseFile,
    Drive,
    History,
    LoadCycle,
    PairContact,
    SphereContact,
    read_case,
    simulate,
    write_case,
)
from exudyn_crawler.case.files.files import saved_case
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.run.folder.checkpoints import Checkpoints

SPHERES = SphereContact.oil_sand()
CASES = {
    "pair": Case.turning(),
    "spheres": Case.translation().with_(contact=SPHERES.with_(radius=0.25, reference_stiffness=2e8)),
    "switched": Case.stress("coarse"),
}


def old_values(case):
    """A case as the release before wrote it: both contacts in full, and the drive's times with the loads."""
    values = json.loads(case.model_dump_json())
    contact = values.pop("contact")
    pair, spheres = PairContact.oil_sand().model_dump(), SPHERES.model_dump()
    if contact.pop("model") == "pair":
        pair |= contact
    else:
        pair |= {"stiffness": contact["reference_stiffness"], "exponent": contact["reference_exponent"]}
        spheres |= contact
    for table in (pair, spheres):
        for name in ("model", "reference_stiffness", "reference_exponent"):
            table.pop(name, None)
    values["contact"], values["general_contact"] = pair, spheres
    values["contact_model"] = case.contact.model.replace("spheres", "general")
    values["loads"]["drive_on"] = values["drive"].pop("on")
    return values


@pytest.fixture
def read(tmp_path):
    """Case of a file's text and the only warning that reading it gave."""

    def read(text):
        path = tmp_path / "old.toml"
        path.write_text(text)
        with pytest.warns(FutureWarning) as caught:
            case = read_case(path).case
        (warning,) = caught
        assert warning.filename == __file__
        return case, str(warning.message).removeprefix(f"{path}: ")

    return read


@pytest.mark.parametrize("name", CASES)
def test_an_old_history_s_case_is_read(name):
    with pytest.warns(FutureWarning, match=r"old\.nc: .* drive\.on in place of loads\.drive_on") as caught:
        assert saved_case(json.dumps(old_values(CASES[name])), "old.nc") == CASES[name]
    assert len(caught) == 1


@pytest.mark.parametrize("name", CASES)
def test_cases_of_today_are_read_without_a_warning(name, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert saved_case(CASES[name].model_dump_json(), "new.nc") == CASES[name]
        path = write_case(CaseFile(case=CASES[name], duration=0.1), tmp_path / "new.toml")
        assert read_case(path).case == CASES[name]


def test_the_warning_says_what_to_write(read):
    case, told = read('base = "translation"\ncontact_model = "general"\n[loads]\ndrive_on = [[0.0, 5.0]]\n')
    assert case == Case.translation().with_(
        contact=SPHERES, drive=Drive.translation().with_(on=((0.0, 5.0),))
    )
    assert told == (
        "old keys are read for this release only; write model = 'spheres' in contact in place of "
        "contact_model and general_contact, drive.on in place of loads.drive_on"
    )


@pytest.mark.parametrize(
    ("text", "contact"),
    [
        ('contact_model = "general"\n[general_contact]\nradius = 0.25', SPHERES.with_(radius=0.25)),
        ('contact_model = "general"\n[contact]\nstiffness = 2e8', SPHERES.with_(reference_stiffness=2e8)),
        ('contact_model = "general"\n[general_contact]\nbase = "oil_sand"', SPHERES),
        ('contact_model = "pair"\n[contact]\nstiffness = 2e8', PairContact.oil_sand().with_(stiffness=2e8)),
        ("[general_contact]\nradius = 0.25", PairContact.oil_sand()),
    ],
)
def test_old_keys_over_a_base(read, text, contact):
    case, told = read(f'base = "translation"\n{text}\n')
    assert case == Case.translation().with_(contact=contact)
    assert f"write model = {contact.model!r} in contact in place of" in told


def test_a_contact_in_full_without_a_model_is_the_pair_law(read, tmp_path):
    new = write_case(CaseFile(case=Case.turning()), tmp_path / "new.toml").read_text()
    old = "".join(line for line in new.splitlines(keepends=True) if not line.startswith("model = "))
    assert "model" not in tomllib.loads(old)["contact"]
    case, told = read(old)
    assert case == Case.turning()
    assert told.endswith("write model = 'pair' in contact")


def test_none_of_an_old_drive_stays_none(read):
    case, _ = read('base = "stress"\n[loads]\nbase = "shovel_cycle"\ndrive_on = "none"\n')
    assert case.drive.on is None
    assert case.loads == LoadCycle.shovel_cycle()


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('contact_model = "hertz"', "contact_model: unknown key; "),
        ('contact_model = "general"\n[contact]\nmodel = "pair"', "contact_model: unknown key; "),
        ("general_contact = 3", "general_contact: unknown key; "),
        (
            "[drive]\non = [[0, 5]]\n[loads]\ndrive_on = [[0, 6]]",
            "loads.drive_on: unknown key; ",
        ),
    ],
)
def test_old_keys_that_contradict_are_refused(tmp_path, text, fault):
    path = tmp_path / "old.toml"
    path.write_text(f'base = "translation"\n{text}\n')
    with pytest.raises(CaseFileError) as caught:
        read_case(path)
    assert any(found.startswith(fault) for found in caught.value.faults)


@pytest.mark.simulation
def test_old_histories_and_checkpoints_go_on(tmp_path, monkeypatch):
    case = Case.translation()
    case = case.with_(solver=case.solver.with_(checkpoint_interval=0.01))
    kept, old = Checkpoints(tmp_path), json.dumps(old_values(case))
    with monkeypatch.context() as before:
        before.setattr(Case, "model_dump_json", lambda _self: old)
        with pytest.warns(FutureWarning, match=r"assembled\.nc: old keys"):
            history = simulate(case, 0.02, False, kept)
        history.save(tmp_path / "old.nc")
    with pytest.warns(FutureWarning, match=r"old\.nc: old keys"):
        assert History.load(tmp_path / "old.nc").case == case
    with pytest.warns(FutureWarning, match=r"stage_0000\.npz: old keys"):
        assert len(kept.load(case)) == 1
