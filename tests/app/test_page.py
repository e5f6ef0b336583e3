"""The page in a browser, the whole way from a machine to two runs beside each other, and who is refused."""

import http.client
import re
import subprocess
import sys
from urllib.parse import urlsplit

import pytest

pytest.importorskip("nicegui", reason="the extra `app` is not installed")

from exudyn_crawler.machines import read_case
from tests.views.conftest import browser  # noqa: F401 - a fixture

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

pytestmark = pytest.mark.slow

SHORT = 'base = "translation"\nname = "short"\nduration = 0.02\n[outputs]\nfigures = false\nforces = false\n'
WAIT = 600e3
OPENS = 10e3
"""Ms, of a machine that has more to do: until a run has ended, and until a list is open."""
TRIES = 10
EXPECTED = re.compile("Resize must be passed a displayed plot div element")
"""What Plotly says of a figure that is hidden."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("work")
    (folder / "short.toml").write_text(SHORT)
    return folder


@pytest.fixture(scope="module")
def address(folder):
    words = [sys.executable, "-u", "-m", "exudyn_crawler", "app", str(folder), "--no-browser"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        yield process.stdout.readline().strip()
        process.terminate()
        assert "started runs go on" in process.communicate(timeout=60)[0]
        assert process.returncode == 0


@pytest.fixture
def opened(browser, address):  # noqa: F811
    """Function that opens the page of a width; no request leaves it, and it says no error."""
    pages = []
    requests = []
    errors = []

    def opened(width):
        page = browser.new_page(viewport={"width": width, "height": 900})
        page.set_default_timeout(WAIT)
        page.on("request", lambda request: requests.append(request.url))
        page.on("console", lambda told: errors.append(told.text) if told.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)
        page.locator('[data-testid="side"] .main-svg').first.wait_for()
        pages.append(page)
        return page

    yield opened
    for page in pages:
        page.close()
    assert [url for url in requests if not url.startswith((address, "data:", "blob:"))] == []
    assert [error for error in errors if not EXPECTED.search(error)] == []


def picked(page, label, option):
    """Pick from a list by keyboard."""
    items = page.get_by_role("option")
    for _ in range(TRIES):
        page.get_by_label(label).last.press("ArrowDown")
        try:
            items.first.wait_for(timeout=OPENS)
            for _ in range(items.all_inner_texts().index(option) + 1):
                page.keyboard.press("ArrowDown")
            page.keyboard.press("Enter")
            items.first.wait_for(state="hidden", timeout=OPENS)
        except sync_api.TimeoutError:
            # Quasar gives up to show a list that the browser has not laid out within 60 ms
            page.keyboard.press("Escape")
        else:
            return
    pytest.fail(f"{option} cannot be picked from {label}")


def tab(page, name):
    """Go to a tab by keyboard."""
    page.get_by_role("tab", name=name, exact=True).press("Enter")


def typed(page, path, text):
    """Type a value into the field of a path."""
    field = page.locator(f'input[data-path="{path}"], [data-path="{path}"] input').first
    field.fill(text)
    field.press("Enter")
    return field


def ran(page, name):
    """Run the case by keyboard, and wait for its results."""
    page.get_by_role("button", name="Run", exact=True).press("Enter")
    page.locator(f'[data-run="{name}"]').get_by_role("button", name="Results").press("Enter")
    page.frame_locator("iframe:visible").get_by_role("heading", name="Crawler track: short").wait_for()


def title_says(page, words):
    page.get_by_test_id("title").filter(has_text=words).wait_for()


def test_the_whole_way_by_keyboard_from_a_machine_to_two_runs_beside_each_other(opened, folder):
    page = opened(1400)
    weight = typed(page, "datasheet.operating_weight", "-3 kg")
    page.get_by_text("must be greater than or equal to 1 kg, got -3").wait_for()
    typed(page, "datasheet.operating_weight", "36 t")
    sync_api.expect(weight).to_have_value("36000 kg", timeout=WAIT)
    page.get_by_text("must be greater than").wait_for(state="hidden")
    picked(page, "or a case file of this folder", "short.toml")
    title_says(page, "short.toml")
    ran(page, "short")
    page.reload()
    tab(page, "Run")
    curves = page.get_by_test_id("curves")
    curves.get_by_text("short: greatest over the machine").wait_for()
    curves.locator(".main-svg").first.wait_for()
    tab(page, "Ground and duty")
    typed(page, "duration", "0.03 s")
    title_says(page, "short.toml, not saved")
    tab(page, "File")
    page.get_by_test_id("save-as").press("Enter")
    title_says(page, re.compile(r"short\.toml$"))
    assert read_case(folder / "short.toml").duration == 0.03
    ran(page, "short_2")
    for width in (1400, 390):
        other = page if width == 1400 else opened(width)
        tab(other, "Results")
        other.frame_locator("iframe:visible").get_by_role("heading", name="Crawler track").wait_for()
        picked(other, "beside", "short")
        compared = other.frame_locator("iframe:visible")
        compared.get_by_role("heading", name="What differs in the results").wait_for()
        assert other.evaluate("document.body.scrollWidth") <= width
        with other.expect_download() as download:
            other.get_by_role("button", name="Save: everything").press("Enter")
            other.get_by_role("link", name="compared.html").press("Enter")
        assert "What differs" in download.value.path().read_text(encoding="utf-8")


def asked(address, path=None, **headers):
    """Status of the answer to a request for a path behind the token, or for another one as it is."""
    parts = urlsplit(address)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60)
    target = parts.path + path if path is None or not path.startswith("/") else path
    connection.request("GET", target, headers={name.capitalize(): value for name, value in headers.items()})
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status


def test_what_comes_from_elsewhere_is_refused(address, folder, tmp_path):
    secret = tmp_path / "secret.toml"
    secret.write_text("secret = true\n")
    (folder / "link.toml").symlink_to(secret)
    assert asked(address, "files/short.toml") == 200
    assert asked(address, "files/link.toml") == 404
    assert asked(address, "files/../../secret.toml") == 403
    assert asked(address, "files/%2e%2e/%2e%2e/secret.toml") == 403
    assert asked(address, f"files/{secret}") == 404
    assert asked(address, "/files/short.toml") == 403
    assert asked(address, "/") == 403
    assert asked(address, "/wrong/files/short.toml") == 403
    assert asked(address, "files/short.toml", host="attacker.example") == 403
    assert asked(address, "files/short.toml", origin="http://attacker.example") == 403
    upgrade = {"connection": "Upgrade", "upgrade": "websocket", "sec-websocket-version": "13"}
    upgrade["sec-websocket-key"] = "dGhlIHNhbXBsZSBub25jZQ=="
    path = "_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    assert asked(address, path, origin="http://attacker.example", **upgrade) == 403
    assert asked(address, f"/{path}", **upgrade) == 403
