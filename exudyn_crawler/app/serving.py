"""Server of the page for this computer alone: an address with a token, and a guard of all requests."""

import hmac
import logging
import secrets
import socket
import sys
import webbrowser
from collections.abc import Callable
from pathlib import Path

import uvicorn
from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles
from nicegui import app as pages, ui
from starlette.datastructures import MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exudyn_crawler.errors import cut_line

HOST = "127.0.0.1"
NAMES = (HOST, "localhost")
"""Hosts in requests of a browser on this computer; any other host would be another site's."""
TITLE = "exudyn-crawler"
FILES = "files"
"""Prefix of the addresses of the folder's files, relative to the page."""
OPTIONAL = "'unsafe-inline' 'unsafe-eval'"
POLICY = (
    f"default-src 'self' {OPTIONAL} data: blob:; frame-ancestors 'self'; form-action 'self'; "
    "base-uri 'self'; object-src 'none'"
)
"""Content security policy of the page: nothing from another host."""
OF_FILES = (
    f"sandbox allow-scripts allow-downloads; default-src data: blob: {OPTIONAL}; frame-ancestors 'self'"
)
"""Content security policy of the folder's files: none of the page's rights, and no loading at all."""
HEADERS = {
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    # a page of a folder changes with the next run
    "cache-control": "no-store",
}
FOREIGN = 1008  # code of a refused websocket


class ShortLines(logging.Filter):
    """Filter that shortens messages with a long address of a request."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Shorten the message of a record, and accept it."""
        record.msg = cut_line(record.getMessage())
        record.args = ()
        return True


class Guard:
    """Application that passes on requests of this computer's browser with the token, and refuses all others.

    `app` is the guarded application. The token is the first part of every path, also of websockets. A foreign
    `Host` would come from another name that leads to this computer, a foreign `Origin` from a page of another
    site.
    """

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self.app = app
        self.hosts = {f"{name}:{port}" for name in NAMES}
        self.start = f"/{token}/"

    def refusal(self, scope: Scope) -> str:
        """Return why a request is refused; empty for an allowed one."""
        headers = scope["headers"]
        hosts = [value.decode("latin-1") for name, value in headers if name == b"host"]
        origins = [value.decode("latin-1") for name, value in headers if name == b"origin"]
        if len(hosts) != 1 or hosts[0] not in self.hosts:
            return "this page answers to this computer alone"
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return "this page answers no other site"
        begin = scope["path"][: len(self.start)]
        if not _same(begin, self.start) and not self.lacks_slash(scope):
            return "the address must be that which exudyn-crawler app has shown, with its token"
        return "hidden files are not shown" if "/." in scope["path"] else ""

    def lacks_slash(self, scope: Scope) -> bool:
        """Return True for the page's address without its last slash, as copied from a line."""
        return scope["type"] == "http" and _same(scope["path"] + "/", self.start)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request of a browser, or refuse it."""

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                is_file = scope["path"].startswith(f"{self.start}{FILES}/")
                headers["content-security-policy"] = OF_FILES if is_file else POLICY
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        reason = self.refusal(scope) if scope["type"] != "lifespan" else ""
        if not reason and scope["type"] != "lifespan" and self.lacks_slash(scope):
            await RedirectResponse(self.start)(scope, receive, send_guarded)
        elif not reason:
            await self.app(scope, receive, send_guarded)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": FOREIGN, "reason": reason})
        else:
            await PlainTextResponse(reason, 403)(scope, receive, send_guarded)


def _same(first: str, second: str) -> bool:
    """Return True for equal texts; the time of the comparison does not tell how much of them is equal."""
    return hmac.compare_digest(first.encode("utf-8"), second.encode("utf-8"))


def serve(
    folder: Path,
    build: Callable[[], object],
    port: int | None = None,
    show: bool = True,
    say: Callable[[str], None] = print,
) -> None:
    """Serve the page of a folder until the process is interrupted.

    `build` fills a page; the files of the folder are below `FILES`. `port` None takes a free port. `show`
    opens the browser; `say` gets the address. Raises ValueError if another program uses the port.
    """
    listening = socket.socket()
    if sys.platform == "win32":
        # the option below would let two programs share a port there
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    else:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port or 0))
        listening.listen()
    except OSError as error:
        listening.close()
        raise ValueError(
            f"--port must be a free one, got {port}, which another program uses ({error.strerror}): name "
            "another, or leave --port out"
        ) from error
    logging.getLogger("nicegui").addFilter(ShortLines())
    port = listening.getsockname()[1]
    token = secrets.token_urlsafe(24)
    # links out of the folder are not followed
    pages.mount(f"/{FILES}", StaticFiles(directory=folder))

    ui.page("/")(build)
    outer = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    ui.run_with(
        outer,
        title=TITLE,
        mount_path=f"/{token}",
        tailwind=False,
        reconnect_timeout=30.0,
        show_welcome_message=False,
    )
    address = f"http://{HOST}:{port}/{token}/"

    @pages.on_startup
    def opened() -> None:
        say(address)
        if show:
            webbrowser.open(address)

    config = uvicorn.Config(
        Guard(outer, port, token),
        log_level="warning",
        ws="wsproto",
        timeout_graceful_shutdown=1,
        server_header=False,
    )
    uvicorn.Server(config).run(sockets=[listening])
