"""Who may come in, asked over real sockets: with a token, and without one at this computer's own address."""

from __future__ import annotations

import http.client
import logging
import socket
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.exceptions import InvalidStatus

from tests.unit.console.served import Served
from turtlewire.console.gate import (
    MAX_BODY,
    Buckets,
    Door,
    Gate,
    is_loopback,
    names_of,
)
from turtlewire.console.rates import Bucket

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

TOKEN = "s3cret-and-l0ng"


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with Served("sim:simple", folder=tmp_path_factory.mktemp("p")) as served:
        yield served


@pytest.fixture(scope="module")
def open_to_all(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with Served("sim:simple", folder=tmp_path_factory.mktemp("p"), token=TOKEN, host="0.0.0.0") as served:
        yield served


@pytest.fixture
def refusals(caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    caplog.set_level(logging.INFO, "turtlewire.console")
    return caplog


# ---------------------------------------------------------------------- token


def test_the_token_comes_once_and_a_cookie_stays(open_to_all: Served) -> None:
    with open_to_all.http() as http:
        entry = http.get("/api/robots", params={"a": "1", "token": TOKEN})
        assert (entry.status_code, entry.headers["location"]) == (303, "/api/robots?a=1")
        cookie = entry.headers["set-cookie"]
        assert TOKEN in cookie
        assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; "))
        assert entry.headers["referrer-policy"] == "no-referrer"
        assert http.get("/api/robots").status_code == 200
        assert http.post("/api/stop").status_code == 200
        with open_to_all.page("car", additional_headers={"Cookie": cookie.split(";")[0]}) as page:
            assert page.id


def test_the_address_leads_nowhere_else(open_to_all: Served) -> None:
    connection = http.client.HTTPConnection(open_to_all.address.removeprefix("http://"))
    connection.request("GET", f"//evil.example/x?token={TOKEN}")
    answer = connection.getresponse()
    assert (answer.status, answer.getheader("location")) == (303, "/evil.example/x")
    connection.close()


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Authorization": "Bearer wrong"},
        {"Authorization": f"Basic {TOKEN}"},
        {"Cookie": "turtlewire_0=" + TOKEN},
        {"Authorization": "Bearer"},
    ],
)
def test_without_the_token_nobody_comes_in(
    open_to_all: Served, headers: dict[str, str], refusals: pytest.LogCaptureFixture
) -> None:
    with open_to_all.http(**headers) as http:
        for method, path in (
            ("GET", "/api/robots"),
            ("POST", "/api/stop"),
            ("GET", "/"),
            ("GET", "/_nicegui/x"),
        ):
            answer = http.request(method, path)
            assert (answer.status_code, answer.json()["code"]) == (401, "token"), path
            assert answer.headers["www-authenticate"] == "Bearer"
    with (
        pytest.raises(InvalidStatus) as caught,
        open_to_all.page("car", additional_headers=headers),
    ):
        pass
    assert caught.value.response.status_code == 403
    assert "refused 127.0.0.1 POST /api/stop: token: " in refusals.text
    assert "refused 127.0.0.1 WEBSOCKET /api/stream: token: " in refusals.text
    assert TOKEN not in refusals.text


def test_the_right_token_for_machines(open_to_all: Served) -> None:
    with open_to_all.http(Authorization=f"Bearer {TOKEN}") as http:
        assert http.get("/api/robots").status_code == 200
    with open_to_all.page("car", additional_headers={"Authorization": f"bearer {TOKEN}"}) as page:
        assert page.id


def test_a_browser_is_told_in_words(open_to_all: Served) -> None:
    with open_to_all.http(Accept="text/html,*/*") as http:
        answer = http.get("/")
    assert answer.headers["content-type"].startswith("text/plain")
    assert "open the whole address" in answer.text


def test_nobody_guesses_for_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("turtlewire.console.gate.GUESSES_AT_ONCE", 3.0)
    with Served("sim:simple", folder=tmp_path, token=TOKEN, host="0.0.0.0") as served, served.http() as http:
        served.service.gate.clock = lambda: 0.0
        answers = [http.get("/", params={"token": f"{i}"}).status_code for i in range(5)]
        assert answers == [401] * 3 + [429] * 2
        # who has it is not kept out by who has not, though they come from one address
        assert http.get("/api/robots", headers={"Authorization": f"Bearer {TOKEN}"}).status_code == 200


# ---------------------------------------------------------------------- Host and Origin


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:80", "", "localhost.evil.example", "192.168.1.2", "[", "::1"]
)
def test_another_name_bent_to_this_address(
    home: Served, host: str, refusals: pytest.LogCaptureFixture
) -> None:
    with home.http() as http:
        answer = http.get("/api/robots", headers={"Host": host})
        assert answer.status_code in (400, 421)  # 400: no Host at all
        assert answer.status_code == 400 or answer.json()["code"] == "host"
    assert not host or "refused 127.0.0.1 GET /api/robots: host: " in refusals.text


@pytest.mark.parametrize("host", ["localhost", "LOCALHOST:1", "127.0.0.1:8080", "[::1]:8080", "localhost."])
def test_its_own_names(home: Served, host: str) -> None:
    with home.http(Host=host) as http:
        assert http.get("/api/robots").status_code == 200


def test_open_to_all_it_goes_by_any_number_and_by_its_own_name(open_to_all: Served) -> None:
    for host in ("192.168.1.2:8080", "[fe80::1]:8080", socket.gethostname(), f"{socket.gethostname()}.local"):
        with open_to_all.http(Host=host, Authorization=f"Bearer {TOKEN}") as http:
            assert http.get("/api/robots").status_code == 200, host
    with open_to_all.http(Host="evil.example", Authorization=f"Bearer {TOKEN}") as http:
        assert http.get("/api/robots").json()["code"] == "host"


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "https://127.0.0.1"},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_pages_of_others_change_nothing(
    home: Served, headers: dict[str, str], refusals: pytest.LogCaptureFixture
) -> None:
    with home.http(**headers) as http:
        for path in ("/api/stop", "/api/sessions", "/api/robots/car/wheel", "/_nicegui_ws/socket.io/"):
            answer = http.post(path)
            assert (answer.status_code, answer.json()["code"]) == (403, "origin")
        assert http.delete("/api/programs/x").json()["code"] == "origin"
    with pytest.raises(InvalidStatus), home.page("car", additional_headers=headers):
        pass
    with pytest.raises(InvalidStatus), home.page("car", additional_headers={**headers, "Connection": "x"}):
        pass
    assert "WEBSOCKET /api/stream: origin: " in refusals.text


def test_its_own_pages_do(home: Served) -> None:
    with home.http(Origin=home.address, **{"Sec-Fetch-Site": "same-origin"}) as http:
        assert http.post("/api/stop").status_code == 200
    with home.page("car", additional_headers={"Origin": home.address}) as page:
        assert page.id


def test_no_page_of_others_shows_it_or_loads_anything_elsewhere(home: Served) -> None:
    with home.http() as http:
        for path in ("/api/robots", "/api/nothing"):
            headers = http.get(path).headers
            assert "frame-ancestors 'none'" in headers["content-security-policy"]
            assert "default-src 'self'" in headers["content-security-policy"]
            assert headers["x-content-type-options"] == "nosniff"
            assert "access-control-allow-origin" not in headers


# ---------------------------------------------------------------------- sizes and rates


def test_a_body_that_is_too_long(home: Served, refusals: pytest.LogCaptureFixture) -> None:
    def endless() -> Iterator[bytes]:
        for _ in range(MAX_BODY // 1024 + 2):
            yield b" " * 1024

    with home.http(**{"Content-Type": "application/json"}) as http:
        answer = http.post("/api/sessions", content=b" " * (MAX_BODY + 1))
        assert (answer.status_code, answer.json()["code"]) == (413, "size")
        answer = http.post("/api/sessions", content=endless())
        assert (answer.status_code, answer.json()["code"]) == (413, "size")
        assert http.get("/api/robots").status_code == 200
    assert "refused 127.0.0.1 POST /api/sessions: size: " in refusals.text


def test_a_flood_is_cut_off_but_for_stops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("turtlewire.console.gate.AT_ONCE", 20.0)
    monkeypatch.setattr("turtlewire.console.gate.RATE_PER_S", 5.0)
    now = 0.0
    with Served("sim:simple", folder=tmp_path) as served, served.http() as http:
        served.service.gate.clock = lambda: now
        answers = [http.get("/api/nothing").status_code for _ in range(22)]
        assert answers == [404] * 20 + [429, 429]
        assert http.post("/api/robots/car/stop").status_code == 200
        assert http.post("/api/stop").status_code == 200
        now = 1.0
        answers = [http.get("/api/nothing").status_code for _ in range(6)]
        assert answers == [404] * 5 + [429]


def test_a_flood_of_refusals_fills_no_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusals: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("turtlewire.console.gate.LINES_AT_ONCE", 3.0)
    now = 0.0
    with Served("sim:simple", folder=tmp_path) as served, served.http(Host="evil.example") as http:
        served.service.gate.clock = lambda: now
        for _ in range(10):
            assert http.get("/").status_code == 421
        assert refusals.text.count(": host: ") == 3
        now = 10.0
        http.get("/")
        assert refusals.text.count(": host: ") == 4
        assert "(and 7 other refusals)" in refusals.text


@given(
    st.lists(st.floats(0.0, 3.0), min_size=1, max_size=200),
    st.floats(0.5, 20.0),
    st.integers(1, 20),
)
def test_a_bucket_never_lets_more_through_than_it_may(
    pauses: list[float], per_s: float, at_once: int
) -> None:
    bucket, now, passed = Bucket(per_s, at_once), 0.0, []
    for pause in pauses:
        now += pause
        if bucket.take(now):
            passed.append(now)
        else:
            assert len(passed) >= at_once
    for first in range(len(passed)):
        for last in range(first, len(passed)):
            assert last - first + 1 <= at_once + (passed[last] - passed[first]) * per_s + 1e-6


def test_addresses_do_not_share_a_bucket_and_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("turtlewire.console.gate.MAX_ADDRESSES", 3)
    buckets = Buckets(1.0, 1.0)
    assert [buckets.take(address, 0.0) for address in "abcabc"] == [True] * 3 + [False] * 3
    assert buckets.take("d", 0.0)  # a is forgotten
    assert buckets.take("a", 0.0)
    assert not buckets.take("d", 0.0)


# ---------------------------------------------------------------------- names and addresses


@pytest.mark.parametrize(
    ("host", "is_own"),
    [
        ("127.0.0.1", True),
        ("localhost", True),
        ("::1", True),
        ("127.0.0.9", True),
        ("0.0.0.0", False),
        ("::", False),
        ("10.0.0.1", False),
        ("robots.example", False),
    ],
)
def test_what_only_this_computer_reaches(host: str, is_own: bool) -> None:
    assert is_loopback(host) == is_own
    assert (socket.gethostname().lower() in names_of(host)) == (not is_own)


@pytest.mark.parametrize(
    ("host", "is_secure", "address"),
    [
        ("127.0.0.1", False, "http://127.0.0.1:8080/"),
        ("::1", False, "http://[::1]:8080/"),
        ("robots.example", True, "https://robots.example:8080/"),
    ],
)
def test_its_address_for_people(host: str, is_secure: bool, address: str) -> None:
    door = Door("", names_of(host), any_address=False, cookie="c", is_secure=is_secure, port=8080)
    assert door.address(host) == address


def test_open_to_all_its_address_is_one_that_others_can_use() -> None:
    door = Door("", names_of("0.0.0.0"), any_address=True, cookie="c", is_secure=False, port=8080)
    assert "0.0.0.0" not in door.address("0.0.0.0") or not _has_network()


def _has_network() -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return False
    return True


def test_what_is_neither_request_nor_socket_goes_through() -> None:
    async def app(scope: object, receive: object, send: object) -> None:
        heard.append(scope)

    heard: list[object] = []
    gate = Gate(
        app, Door("", frozenset(), any_address=False, cookie="c", is_secure=False, port=1), lambda: 0.0
    )
    coroutine = gate({"type": "lifespan"}, None, None)  # type: ignore[arg-type] # neither is used
    with pytest.raises(StopIteration):
        coroutine.send(None)
    assert heard == [{"type": "lifespan"}]
