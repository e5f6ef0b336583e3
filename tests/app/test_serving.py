"""Who is answered: this computer's browser with the token, about files of the folder, and nobody else."""

import asyncio
import logging
import socket
from concurrent.futures import ThreadPoolExecutor

import pytest

pytest.importorskip("nicegui", reason="the extra `app` is not installed")

from exudyn_crawler.app.serving import Guard, ShortLines, serve

HOST = "127.0.0.1:5000"
PATH = "/secret/files/mine.toml"


async def inner(scope, receive, send):
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    else:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"answered"})


def asked(path=PATH, host=HOST, origin=None, kind="http", more=()):
    """Messages that the guard sends to a request."""
    headers = [(b"host", host.encode())] if host else []
    headers += [(b"origin", origin.encode())] if origin else []
    scope = {"type": kind, "path": path, "headers": [*headers, *more], "method": "GET"}
    sent = []

    async def receive():
        return {"type": f"{kind}.connect"}

    async def send(message):
        sent.append(message)

    # in a thread: in this one the loop of a browser, which other tests hold open, may be running
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, Guard(inner, 5000, "secret")(scope, receive, send)).result()
    return sent


@pytest.mark.parametrize("host", [HOST, "localhost:5000"])
def test_the_own_page_is_answered_and_may_load_nothing_from_elsewhere(host):
    first, body = asked("/secret/", host=host, origin=f"http://{host}")
    assert first["status"] == 200
    assert body["body"] == b"answered"
    headers = dict(first["headers"])
    assert headers[b"referrer-policy"] == b"no-referrer"
    assert b"default-src 'self'" in headers[b"content-security-policy"]
    assert b"http" not in headers[b"content-security-policy"]
    assert asked(kind="websocket", origin=f"http://{HOST}") == [{"type": "websocket.accept"}]


REFUSED = {
    "another name": {"host": "attacker.example:5000"},
    "another port": {"host": "127.0.0.1:5001"},
    "no name": {"host": ""},
    "two names": {"more": [(b"host", b"attacker.example")]},
    "another site": {"origin": "http://attacker.example"},
    "another program of this computer": {"origin": "http://127.0.0.1:8000"},
    "a page without a site": {"origin": "null"},
    "no token": {"path": "/files/mine.toml"},
    "a wrong token": {"path": "/secre7/files/mine.toml"},
    "a part of the token": {"path": "/secre"},
    "more than the token": {"path": "/secret2/files/mine.toml"},
    "a hidden file": {"path": "/secret/files/results/mine/.lock"},
    "a folder above": {"path": "/secret/files/../other.toml"},
}


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize("request_of", REFUSED.values(), ids=REFUSED)
def test_others_are_refused(request_of, kind):
    first, *_ = asked(kind=kind, **request_of)
    if kind == "http":
        assert first["status"] == 403
    else:
        assert first["type"] == "websocket.close"


def test_files_of_the_folder_get_none_of_the_rights_of_the_page():
    headers = dict(asked()[0]["headers"])
    assert b"default-src data:" in headers[b"content-security-policy"]
    assert b"sandbox" in headers[b"content-security-policy"]
    assert headers[b"cache-control"] == b"no-store"


def test_the_address_without_its_last_slash_leads_to_the_page():
    first, *_ = asked("/secret")
    assert first["status"] == 307
    assert dict(first["headers"])[b"location"] == b"/secret/"
    assert asked("/secret", kind="websocket")[0]["type"] == "websocket.close"
    assert asked("/secret", origin="http://attacker.example")[0]["status"] == 403


def test_a_taken_port_is_named_with_its_flag(tmp_path):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ValueError, match=rf"--port must be a free one, got {port}, .* leave --port out"):
            serve(tmp_path, list, port, show=False)


def test_long_addresses_are_cut_on_the_console():
    record = logging.makeLogRecord({"msg": "%s not found", "args": ("http://here/" + 10_000 * "x",)})
    assert ShortLines().filter(record)
    assert len(record.getMessage()) < 600
    assert record.getMessage().startswith("http://here/x")
    assert record.getMessage().endswith("x not found")
