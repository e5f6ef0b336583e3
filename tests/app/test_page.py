"""The page in a browser, the whole way from a machine to two runs beside each other, and who is refused."""

import http.client
import re
import subprocess
import sys
from urllib.parse import urlsplit

import pytest

pytest.importorskip("nicegui", reason="the extra `app` is not installed")

from exudyn_crawler.case import read_case
from tests.views.conftest import browser  # noqa: F401 - a fixture

pytestmark = pytest.mark.slow

SHORT = 'base = "translation"\nname = "short"\nduration = 0.02\n[outputs]\nfigures = false\nforces = false\n'
WAIT = 300e3  # ms
TITLE = '[data-testid="title"]'
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
        assert "runs that had begun go on" in process.communicate(timeout=30)[0]
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


def field(page, path):
    return page.locator(f'input[data-path="{path}"], [data-path="{path}"] input').first


def started(page, number):
    """Press Run by keyboard, and wait until so many runs are done."""
    page.get_by_test_id("run").press("Enter")
    page.get_by_text("done", exact=True).nth(number - 1).wait_for()


def test_the_whole_way_from_a_machine_to_two_runs_beside_each_other(opened, folder):
    page = opened(1400)
    weight = field(page, "datasheet.operating_weight")
    weight.fill("-3 kg")
    weight.press("Tab")
    page.get_by_text("must be greater than or equal to 1, got -3").wait_for()
    weight.fill("36 t")
    weight.press("Enter")
    page.get_by_text("must be greater than").wait_for(state="hidden")
    assert weight.input_value() == "36000 kg"
    page.get_by_label("or a case file of this folder").click()
    page.get_by_role("option", name="short.toml").click()
    page.locator(TITLE, has_text="short.toml").wait_for()
    started(page, 1)
    # the arrows of the keyboard go from tab to tab
    page.get_by_role("tab", name="Run", exact=True).press("ArrowLeft")
    page.get_by_role("tab", name="Ground and duty").click()
    duration = field(page, "duration")
    duration.fill("0.03 s")
    duration.press("Enter")
    page.locator(TITLE, has_text="not saved").wait_for()
    started(page, 2)
    assert read_case(folder / "short_2.toml").duration == 0.03
    page.locator('[data-run="short_2"]').get_by_role("button", name="Results").click()
    page.locator(".answer").first.wait_for()
    report = page.frame_locator("iframe:visible")
    report.get_by_role("heading", name="Crawler track: short").wait_for()
    for width in (1400, 390):
        other = page if width == 1400 else opened(width)
        other.get_by_role("tab", name="Results").click()
        other.locator(".answer").first.wait_for()
        other.get_by_label("beside").click()
        other.get_by_role("option").first.click()
        compared = other.frame_locator("iframe:visible")
        compared.get_by_role("heading", name="What differs in the results").wait_for()
        assert other.evaluate("document.body.scrollWidth") <= width


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
    assert asked(address, "files/../../secret.toml") == 404
    assert asked(address, "files/%2e%2e/%2e%2e/secret.toml") == 404
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
