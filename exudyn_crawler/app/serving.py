"""Serving of the page on this computer alone: an address with a token, and a guard before it."""

import hmac
import logging
import secrets
import socket
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
"""Names by which a browser on this computer asks; any other name would be another site's."""
TITLE = "exudyn-crawler"
FILES = "files"
"""Begin of the addresses of the folder's files, from the page's own."""
OPTIONAL = "'unsafe-inline' 'unsafe-eval'"
POLICY = (
    f"default-src 'self' {OPTIONAL} data: blob:; frame-ancestors 'self'; form-action 'self'; "
    "base-uri 'self'; object-src 'none'"
)
"""What a browser may load for the page: nothing from another host."""
OF_FILES = (
    f"sandbox allow-scripts allow-downloads; default-src data: blob: {OPTIONAL}; frame-ancestors 'self'"
)
"""Same for files of the folder, which get none of the page's rights and load nothing at all."""
HEADERS = {
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    # a page of a folder is another one after the next run
    "cache-control": "no-store",
}
FOREIGN = 1008  # code with which a websocket is refused


class ShortLines(logging.Filter):
    """Filter that cuts messages which repeat a long address of a request."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Cut the message of a record, and let it pass."""
        record.msg = cut_line(record.getMessage())
        record.args = ()
        return True


class Guard:
    """Application that hands on what this computer's browser asks for with the token, and refuses all else.

    `app` is what is guarded; the token is the first part of every path, also of websockets. A foreign `Host`
    is how a name that leads to this computer would reach it, a foreign `Origin` a page of another site.
    """

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self.app = app
        self.hosts = {f"{name}:{port}" for name in NAMES}
        self.start = f"/{token}/"

    def refusal(self, scope: Scope) -> str:
        """Why a request is refused; empty for one that is not."""
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
        """Return True for the page's address without the slash at its end, as it is copied from a line."""
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
    """Return True for equal texts, after a time that does not tell how much of them is equal."""
    return hmac.compare_digest(first.encode("utf-8"), second.encode("utf-8"))


def serve(
    folder: Path,
    build: Callable[[], object],
    port: int | None = None,
    show: bool = True,
    say: Callable[[str], None] = print,
) -> None:
    """Serve the page of a folder until the process is interrupted.

    `build` fills a page, for which files of the folder are below `FILES`. `port` None takes a free one;
    ValueError if another program has it. `show` opens the browser; `say` gets the address.
    """
    listening = socket.socket()
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
    # links that lead out of the folder are not followed
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
