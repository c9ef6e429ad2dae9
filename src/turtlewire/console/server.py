"""Makes the console's application, and serves it. Signals, exit codes and stopping the robots are the command's."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import socket
import ssl
from typing import TYPE_CHECKING

import uvicorn
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from turtlewire.console import models, program_routes, routes, traffic_routes
from turtlewire.console.gate import Door, Gate, ipaddress_of, names_of
from turtlewire.console.refusals import Refused
from turtlewire.errors import DataError, UsageError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from pathlib import Path

    from turtlewire.console.console import Console

log = logging.getLogger("turtlewire.console")
MAX_SOCKET_MESSAGE = 64 * 1024
# Pages have so long to go when the console ends; their robots have been stopped by then.
GRACE_S = 1
REFUSALS: dict[int | str, dict[str, object]] = {
    status: {"model": models.Refusal} for status in (400, 401, 403, 404, 409, 413, 421, 422, 429)
}


def application(console: Console) -> FastAPI:
    """The HTTP and WebSocket API of a console."""
    from importlib.metadata import version

    @contextlib.asynccontextmanager
    async def alive(app: FastAPI) -> AsyncIterator[None]:
        del app
        console.stations.open()
        try:
            yield
        finally:
            await console.stations.close()

    app = FastAPI(
        title="turtlewire console",
        version=version("turtlewire"),
        openapi_url="/api/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=alive,
        responses=REFUSALS,
    )
    app.state.console = console
    app.state.programs = console.programs
    app.add_exception_handler(Refused, _refused)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _failed)
    app.include_router(routes.router)
    app.include_router(program_routes.router)
    app.include_router(traffic_routes.router)
    return app


async def _refused(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, Refused)
    log.info("refused %s %s %s: %s", routes.address_of(request), request.method, request.url.path, error.text)
    return JSONResponse(error.as_json(), error.status)


async def _invalid(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    details = [{"where": ".".join(map(str, each["loc"])), "text": each["msg"]} for each in error.errors()]
    text = "; ".join(f"{each['where']}: {each['text']}" for each in details)
    log.info("refused %s %s %s: %s", routes.address_of(request), request.method, request.url.path, text)
    return JSONResponse({"code": "invalid", "text": text, "details": details}, 422)


async def _failed(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    del request
    codes = {404: "no_such_page", 405: "method"}
    code = codes.get(error.status_code, "refused")
    return JSONResponse(
        {"code": code, "text": str(error.detail)}, error.status_code, headers=dict(error.headers or {})
    )


class _Server(uvicorn.Server):
    """Leaves signals to the command."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Nothing."""
        yield


class Service:
    """A console that listens.

    Args:
        console: what is served.
        door: how it is reached.
        listener: its socket, see ``listen``.
        certificate, key: of TLS, see ``check_certificate``.
    """

    def __init__(
        self,
        console: Console,
        door: Door,
        listener: socket.socket,
        *,
        certificate: Path | None = None,
        key: Path | None = None,
        with_page: bool = True,
    ) -> None:
        self.console = console
        app = application(console)
        if with_page:
            from turtlewire.console.page import mount

            mount(app)
        self._listener = listener
        self.gate = Gate(app, door, console.now)
        self._server = _Server(
            uvicorn.Config(
                self.gate,
                ws="websockets-sansio",
                ws_max_size=MAX_SOCKET_MESSAGE,
                ws_per_message_deflate=False,
                log_config=None,
                access_log=False,
                server_header=False,
                proxy_headers=False,
                timeout_graceful_shutdown=GRACE_S,
                ssl_certfile=certificate,
                ssl_keyfile=key,
            )
        )

    def run(self) -> None:
        """Serve until ``end``; the robots are stopped at the end, whatever ends it."""
        asyncio.run(self.serve())

    async def serve(self) -> None:
        """``run``, in an event loop."""
        try:
            await self._server.serve(sockets=[self._listener])
        finally:
            await self.console.stations.close()

    def end(self) -> None:
        """Stop the robots, and end; from any thread, or a signal's handler."""
        self.console.stations.end()
        self._server.should_exit = True


def door(host: str, listener: socket.socket, token: str, *, is_secure: bool) -> Door:
    """How a console is reached that listens there."""
    port = listener.getsockname()[1]
    address = ipaddress_of(host)
    return Door(
        token=token,
        names=names_of(host),
        any_address=address is not None and address.is_unspecified,
        cookie=f"turtlewire_{port}",
        is_secure=is_secure,
        port=port,
    )


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens there. Raises ``UsageError``."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, _, _, address = found[0]
        listener = socket.socket(family, kind)
    except (OSError, UnicodeError) as error:
        raise UsageError(f"--host {host}: {_why(error)}. Name an address of this computer") from None
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(128)
    except OSError as error:
        listener.close()
        if error.errno == errno.EADDRINUSE:
            raise UsageError(
                f"port {port} of {host} is in use, perhaps by another console: name another one by --listen-port, or 0 "
                "for any that is free"
            ) from None
        raise UsageError(f"nothing can listen at port {port} of {host}: {_why(error)}") from None
    return listener


def check_certificate(certificate: Path, key: Path | None) -> None:
    """Raises ``DataError`` for a certificate and a key that are none, or do not belong together."""
    for path in filter(None, (certificate, key)):
        try:
            path.read_bytes()
        except OSError as error:
            raise DataError(f"{path}: {_why(error)}") from None
    try:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key, password=lambda: "")
    except (ssl.SSLError, ValueError) as error:
        where = f"{certificate} and {key}" if key else str(certificate)
        why = getattr(error, "reason", None) or str(error)
        raise DataError(
            f"{where}: no certificate with its key, as TLS needs them ({why}). PEM files are expected: the "
            "certificate's by --certificate, the key's by --key if it has one of its own"
        ) from None


def _why(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
