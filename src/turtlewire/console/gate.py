"""Who may come in: everything that reaches the console comes through here, NiceGUI's own socket too.

- *Host*: one of the console's own names (a page elsewhere whose name was bent to this address, "DNS rebinding").
- *Origin*: what changes anything, and every socket, must come from the console's own pages, or from no page at all.
- *Token*: where the console is open to others than this computer. It comes with the first address (``?token=``), which
  is answered by a cookie that scripts cannot read and other sites do not send; or as ``Authorization: Bearer``.
- *Size* of a body, and *rate* of requests, for each address. A stop is never too many.

Every refusal is logged, with who and why.
"""

from __future__ import annotations

import contextlib
import hmac
import ipaddress
import json
import logging
import re
import socket
from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import parse_qsl, urlencode, urlsplit

from turtlewire.console.rates import Bucket
from turtlewire.console.refusals import Refused

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

log = logging.getLogger("turtlewire.console")
MAX_BODY = 256 * 1024
# Requests of one address: a page loads about forty files when it is opened. A class may sit behind one address.
RATE_PER_S, AT_ONCE = 100.0, 1000.0
# Wrong tokens of one address.
GUESSES_PER_S, GUESSES_AT_ONCE = 0.2, 20.0
MAX_ADDRESSES = 4096
# Refusals in the log.
LINES_PER_S, LINES_AT_ONCE = 10.0, 100.0
TOO_LONG = 1009
SAFE = ("GET", "HEAD", "OPTIONS")
STOPS = re.compile(r"/api/(robots/[^/]+/)?stop")
HEADERS = {
    "content-security-policy": "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' "
    "'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'self'",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
}
# What is made of our own modules may be another one after an update.
OURS = re.compile(r"/_nicegui/[^/]+/(esm|components)/")


class Door(NamedTuple):
    """How the console is reached.

    Attributes:
        token: that is asked for; "": none is.
        names: that it goes by, in lower case, without a port.
        any_address: whether any numeric address is one of its names: it listens on all of this computer's.
        cookie: what the token's is called. Cookies know no ports: two consoles need two names.
        is_secure: TLS.
        port: that it listens at.
    """

    token: str
    names: frozenset[str]
    any_address: bool
    cookie: str
    is_secure: bool
    port: int

    def address(self, host: str) -> str:
        """The console's URL, for people; ``host`` is what it listens at."""
        address = ipaddress_of(host)
        if address is not None and address.is_unspecified:
            host = own_address() or host
        elif address is not None and address.version == 6:
            host = f"[{host}]"
        return f"{'https' if self.is_secure else 'http'}://{host}:{self.port}/"


def names_of(host: str) -> frozenset[str]:
    """What a console that listens at this address may be called."""
    names = {host.lower(), "localhost", "127.0.0.1", "::1"}
    if not is_loopback(host):
        own = socket.gethostname().lower()
        names |= {own, f"{own}.local", socket.getfqdn().lower()}
    return frozenset(names)


def own_address() -> str | None:
    """This computer's address in its network: that from which it would reach others. Nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, contextlib.suppress(OSError):
        probe.connect(("192.0.2.1", 9))  # an address that is nobody's (RFC 5737)
        return str(probe.getsockname()[0])
    return None


def ipaddress_of(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """The numeric address that this is; None: it is a name."""
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None


def is_loopback(host: str) -> bool:
    """Whether nobody but this computer can reach this address."""
    address = ipaddress_of(host)
    return host == "localhost" if address is None else address.is_loopback


class Request:
    """What the gate looks at."""

    def __init__(self, scope: Scope) -> None:
        self.is_socket = scope["type"] == "websocket"
        self.method = "WEBSOCKET" if self.is_socket else str(scope["method"])
        self.path = str(scope["path"])
        self.query = scope["query_string"].decode("latin-1")
        self.address = scope["client"][0] if scope.get("client") else "?"
        self._headers: dict[str, str] = {}
        for name, value in scope["headers"]:
            self._headers.setdefault(name.decode("latin-1").lower(), value.decode("latin-1"))

    def header(self, name: str) -> str | None:
        """A header, None without it."""
        return self._headers.get(name)

    def cookie(self, name: str) -> str | None:
        """A cookie, None without it."""
        for pair in self._headers.get("cookie", "").split(";"):
            key, _, value = pair.strip().partition("=")
            if key == name:
                return value
        return None


class Gate:
    """Lets in what may come in.

    Args:
        app: behind it.
        door: how the console is reached.
        clock: seconds; it can be changed.

    Attributes:
        clock: seconds.
    """

    def __init__(self, app: ASGIApp, door: Door, clock: Callable[[], float]) -> None:
        self._app = app
        self._door = door
        self.clock = clock
        self._requests = Buckets(RATE_PER_S, AT_ONCE)
        self._lines = Bucket(LINES_PER_S, LINES_AT_ONCE)
        self._unlogged = 0
        self._guesses = Buckets(GUESSES_PER_S, GUESSES_AT_ONCE)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request, or one socket."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        request = Request(scope)
        try:
            self._check(request)
            entry = self._entry(request)
        except Refused as refusal:
            await self._refuse(request, refusal, send)
            return
        if entry is not None:
            await _answer(send, 303, b"", [("location", entry), ("set-cookie", self._set_cookie())])
            return
        if request.is_socket:
            await self._app(scope, self._watched(request, receive), send)
            return
        body = Body(receive)
        # What reads the body may make something else of its refusal.
        with contextlib.suppress(Refused):
            await self._app(scope, body.receive, _with_headers(send, request, body))
        if body.refusal is not None:
            await self._refuse(request, body.refusal, send)

    def _watched(self, request: Request, receive: Receive) -> Receive:
        """A socket's messages; one that was too long has ended it."""

        async def watched() -> Message:
            message = await receive()
            if message["type"] == "websocket.disconnect" and message.get("code") == TOO_LONG:
                self._note(request, "size", "a message was too long")
            return message

        return watched

    def _check(self, request: Request) -> None:
        """Raises ``Refused``."""
        now = self.clock()
        if not STOPS.fullmatch(request.path) and not self._requests.take(request.address, now):
            raise Refused(429, "rate", f"more than {RATE_PER_S:.0f} requests a second come from this address")
        self._check_host(request)
        self._check_origin(request)
        length = request.header("content-length")
        if length is not None and not (length.isdecimal() and int(length) <= MAX_BODY):
            raise Refused(413, "size", f"a request is at most {MAX_BODY} bytes long")

    def _check_host(self, request: Request) -> None:
        host = _host_name(request.header("host") or "")
        if host in self._door.names or (self._door.any_address and ipaddress_of(host) is not None):
            return
        raise Refused(
            421,
            "host",
            f"this console is not called {host[:100]!r}: use the address that it was started with",
        )

    def _check_origin(self, request: Request) -> None:
        origin = request.header("origin")
        if origin is None:
            site = request.header("sec-fetch-site")
            is_foreign = site not in (None, "same-origin", "none") and request.method not in SAFE
        else:
            own = f"{'https' if self._door.is_secure else 'http'}://{request.header('host')}"
            is_foreign = origin.lower() != own.lower() and request.method not in SAFE
        if is_foreign:
            raise Refused(
                403,
                "origin",
                f"this came from a page of {(origin or 'another site')[:200]!r}, not from the console's own",
            )

    def _entry(self, request: Request) -> str | None:
        """Where to send whoever comes with the token in the address. Raises ``Refused`` without it."""
        token = self._door.token
        if not token:
            return None
        said = [value for name, value in parse_qsl(request.query) if name == "token"]
        if said and request.method == "GET":
            self._compare(request, said[0])
            rest = urlencode([pair for pair in parse_qsl(request.query) if pair[0] != "token"])
            path = "/" + request.path.lstrip("/")
            return f"{path}?{rest}" if rest else path
        bearer = request.header("authorization") or ""
        if bearer.lower().startswith("bearer "):
            self._compare(request, bearer[7:].strip())
            return None
        cookie = request.cookie(self._door.cookie)
        if cookie is None:
            raise Refused(
                401,
                "token",
                "this console asks for its token: open the whole address that it showed when it was started, or send "
                "Authorization: Bearer TOKEN",
            )
        self._compare(request, cookie)
        return None

    def _compare(self, request: Request, token: str) -> None:
        if hmac.compare_digest(token.encode(), self._door.token.encode()):
            return
        if not self._guesses.take(request.address, self.clock()):
            raise Refused(429, "guesses", "too many wrong tokens have come from this address: wait a minute")
        raise Refused(401, "token", "this is not the console's token: it is a new one at each start")

    def _set_cookie(self) -> str:
        secure = "; Secure" if self._door.is_secure else ""
        return f"{self._door.cookie}={self._door.token}; Path=/; HttpOnly; SameSite=Strict{secure}"

    def _note(self, request: Request, code: str, text: str) -> None:
        """In the log: all refusals, but for a flood of them, which is counted."""
        if not self._lines.take(self.clock()):
            self._unlogged += 1
            return
        more, self._unlogged = self._unlogged, 0
        said = f" (and {more} other refusals)" if more else ""
        log.warning(
            "refused %s %s %.200s: %s: %s%s", request.address, request.method, request.path, code, text, said
        )

    async def _refuse(self, request: Request, refusal: Refused, send: Send) -> None:
        self._note(request, refusal.code, refusal.text)
        if request.is_socket:
            await send({"type": "websocket.close", "code": 1008, "reason": refusal.code})
            return
        content = json.dumps({"code": refusal.code, "text": refusal.text}).encode()
        kind = "application/json"
        if "text/html" in (request.header("accept") or ""):
            content, kind = f"turtlewire: {refusal.text}\n".encode(), "text/plain; charset=utf-8"
        extra = [("content-type", kind)]
        if refusal.status == 401:
            extra.append(("www-authenticate", "Bearer"))
        await _answer(send, refusal.status, content, extra)


class Buckets:
    """A bucket for each address; the addresses that were not heard of for longest are forgotten."""

    def __init__(self, per_s: float, at_once: float) -> None:
        self._per_s, self._at_once = per_s, at_once
        self._buckets: OrderedDict[str, Bucket] = OrderedDict()

    def take(self, address: str, now: float) -> bool:
        """One more of this address; False: that is too many."""
        bucket = self._buckets.pop(address, None) or Bucket(self._per_s, self._at_once)
        self._buckets[address] = bucket
        if len(self._buckets) > MAX_ADDRESSES:
            self._buckets.popitem(last=False)
        return bucket.take(now)


class Body:
    """Counts what comes.

    Attributes:
        refusal: it was too long, and this is the answer.
    """

    def __init__(self, receive: Receive) -> None:
        self.refusal: Refused | None = None
        self._receive = receive
        self._size = 0

    async def receive(self) -> Message:
        """The next message; raises ``Refused`` when a body grows too long."""
        message = await self._receive()
        if message["type"] == "http.request":
            self._size += len(message.get("body", b""))
            if self._size > MAX_BODY:
                self.refusal = Refused(413, "size", f"a request is at most {MAX_BODY} bytes long")
                raise self.refusal
        return message


def _host_name(host: str) -> str:
    """Without the port, and without the brackets of an IPv6 address."""
    try:
        return (urlsplit(f"//{host}").hostname or "").rstrip(".")
    except ValueError:
        return ""


def _with_headers(send: Send, request: Request, body: Body) -> Send:
    async def send_with(message: Message) -> None:
        if body.refusal is not None:
            return
        if message["type"] == "http.response.start":
            headers = list(message.get("headers", []))
            if OURS.match(request.path):
                headers = [pair for pair in headers if pair[0].lower() != b"cache-control"]
                headers.append((b"cache-control", b"no-cache"))
            message = {**message, "headers": headers + _encoded(HEADERS.items())}
        await send(message)

    return send_with


async def _answer(send: Send, status: int, content: bytes, headers: Iterable[tuple[str, str]]) -> None:
    length = ("content-length", str(len(content)))
    plain = [*headers, length, ("cache-control", "no-store"), *HEADERS.items()]
    await send({"type": "http.response.start", "status": status, "headers": _encoded(plain)})
    await send({"type": "http.response.body", "body": content})


def _encoded(headers: Iterable[tuple[str, str]]) -> list[tuple[bytes, bytes]]:
    return [(name.encode("latin-1"), value.encode("latin-1")) for name, value in headers]
