"""Programs over HTTP: a real server with a real simulated robot, as a machine uses it."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

import httpx
import pytest

from turtlewire.configuration import target
from turtlewire.console.console import Console
from turtlewire.console.programs import LARGEST, Programs
from turtlewire.console.server import Service, door, listen
from turtlewire.console.stations import Berth

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

DEADLINE_S = 40.0
FINAL = ("ended", "failed", "stopped")


def wait_until(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.005)


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A console without its page; its WALTER lives ten times as fast as we do."""
    console = Console(
        [Berth(target("sim:walter"), 10.0)], lambda _text: None, Programs(tmp_path_factory.mktemp("programs"))
    )
    with listen("127.0.0.1", 0) as listener:
        service = Service(
            console, door("127.0.0.1", listener, "", is_secure=False), listener, with_page=False
        )
        thread = threading.Thread(target=service.run)
        thread.start()
        address = f"http://127.0.0.1:{listener.getsockname()[1]}"
        with httpx.Client(base_url=address, trust_env=False) as client:
            wait_until(lambda: client.get("/api/robots").json()[0]["reached"], "the robot")
        yield address
        service.end()
        thread.join()


@pytest.fixture
def client(url: str) -> Iterator[httpx.Client]:
    """Somebody who has the wheel."""
    with httpx.Client(base_url=url, timeout=DEADLINE_S, trust_env=False) as made:
        session = made.post("/api/sessions", json={"name": "a machine"}).json()["session"]
        made.headers["X-Session"] = session
        assert made.post("/api/robots/walter/wheel", json={"action": "take"}).status_code == 200
        yield made
        made.post("/api/robots/walter/stop")
        wait_until(lambda: (state(made) or {"phase": "ended"})["phase"] in FINAL, "the program's end")


def state(client: httpx.Client) -> dict[str, Any] | None:
    found: dict[str, Any] | None = client.get("/api/robots/walter/program").json()
    return found


def phase(client: httpx.Client, *names: str) -> dict[str, Any]:
    wait_until(lambda: (state(client) or {})["phase"] in names, f"{names}: {state(client)}")
    found = state(client)
    assert found is not None
    return found


def begin(client: httpx.Client, source: str, **how: Any) -> dict[str, Any]:
    answer = client.post("/api/robots/walter/program", json={"source": source, "name": "p.logo", **how})
    assert answer.status_code == 201, answer.text
    found: dict[str, Any] = answer.json()
    return found


def test_a_program_from_its_beginning_to_its_end(client: httpx.Client) -> None:
    number = begin(client, 'cs fd 20 print "Å')["number"]
    told = phase(client, "ended")
    assert (told["number"], told["name"], told["source"]) == (number, "p.logo", 'cs fd 20 print "Å')
    output = client.get("/api/robots/walter/program/output").json()
    assert output == {"number": number, "from": 0, "text": "Å\n"}
    assert client.get("/api/robots/walter/program/output", params={"since": 1}).json()["text"] == "\n"
    # As everybody is told it by the stream; the source is too long for that.
    seen = client.get("/api/robots/walter").json()["program"]
    assert seen["phase"] == "ended"
    assert "source" not in seen


def test_paused_stepped_looked_into_and_ended(client: httpx.Client) -> None:
    begin(
        client,
        "to p :n\n  print :n\nend\np 1\nprint readword\nforever [fd 1 bk 1]",
        paused=True,
        breakpoints=[5],
    )
    robot = "/api/robots/walter/program"
    assert phase(client, "paused")["line"] == 4
    assert client.post(f"{robot}/step", json={"how": "into"}).status_code == 200
    wait_until(lambda: (state(client) or {})["line"] == 2, "line 2")
    assert phase(client, "paused")["paused"]["variables"] == {"n": "1"}
    assert client.post(f"{robot}/do", json={"source": "print :n + 100"}).status_code == 200
    assert client.post(f"{robot}/continue").status_code == 200
    wait_until(lambda: (state(client) or {})["line"] == 5, "line 5")
    phase(client, "paused")
    client.post(f"{robot}/continue")
    phase(client, "asking")
    assert client.post(f"{robot}/input", json={"text": "typed"}).status_code == 200
    phase(client, "running")
    assert client.post(f"{robot}/pause").status_code == 200
    phase(client, "paused")
    assert client.put(f"{robot}/breakpoints", json={"lines": []}).status_code == 200
    assert client.post(f"{robot}/step").status_code == 200
    assert client.post(f"{robot}/stop").status_code == 200
    phase(client, "stopped")
    assert client.get(f"{robot}/output").json()["text"] == "101\n1\ntyped\ntyped\n"
    # Whoever ends a program of their own goes on driving.
    assert client.get("/api/robots/walter").json()["wheel"]["driver"] is not None


def test_while_a_program_runs_nobody_drives_and_nobody_begins_another(client: httpx.Client) -> None:
    begin(client, "forever [fd 10 bk 10]")
    phase(client, "running")
    again = client.post("/api/robots/walter/program", json={"source": "fd 1"})
    assert (again.status_code, again.json()["code"]) == (409, "program_runs")
    pen = client.post("/api/robots/walter/commands", json={"command": "pen"})
    assert (pen.status_code, pen.json()["code"]) == (409, "program_runs")


def test_anybody_stops_it_and_only_who_drives_runs_it(client: httpx.Client, url: str) -> None:
    begin(client, "forever [fd 10 bk 10]")
    with httpx.Client(base_url=url, timeout=DEADLINE_S, trust_env=False) as other:
        path = "/api/robots/walter/program"
        for method, where, body in (
            ("POST", path, {"source": "fd 1"}),
            ("POST", f"{path}/pause", None),
            ("POST", f"{path}/continue", None),
            ("POST", f"{path}/step", None),
            ("POST", f"{path}/stop", None),
            ("POST", f"{path}/do", {"source": "fd 1"}),
            ("POST", f"{path}/input", {"text": "x"}),
            ("PUT", f"{path}/breakpoints", {"lines": []}),
        ):
            assert other.request(method, where, json=body).status_code == 401, where
        other.headers["X-Session"] = other.post("/api/sessions", json={}).json()["session"]
        refused = other.post(path, json={"source": "fd 1"})
        assert refused.status_code == 409
        assert other.post("/api/robots/walter/stop").status_code == 200
    phase(client, "stopped")
    assert (
        client.post("/api/robots/walter/program", json={"source": "fd 1"}).status_code == 409
    )  # the wheel is gone


def test_what_cannot_be_done_now_is_refused(client: httpx.Client) -> None:
    begin(client, "print 1")
    phase(client, "ended")
    path = "/api/robots/walter/program"
    for where, body, code in (
        ("pause", None, "not_running"),
        ("continue", None, "not_running"),
        ("input", {"text": "x"}, "not_running"),
    ):
        answer = client.post(f"{path}/{where}", json=body)
        assert (answer.status_code, answer.json()["code"]) == (409, code)
    begin(client, "forever []")
    phase(client, "running")
    assert client.post(f"{path}/step").json()["code"] == "not_paused"


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"source": 5},
        {"source": "fd 1", "paused": "x"},
        {"source": "fd 1", "breakpoints": [0]},
        {"source": "x" * (LARGEST + 1)},
        {"source": "fd 1", "other": 1},
        [],
        "fd 1",
    ],
)
def test_a_malformed_request_begins_nothing(client: httpx.Client, body: Any) -> None:
    answer = client.post("/api/robots/walter/program", json=body)
    assert answer.status_code == 422
    assert answer.json()["code"] == "invalid"


def test_findings_have_their_places(client: httpx.Client) -> None:
    found = client.post("/api/check", json={"source": "fd 10\nforwrd 5", "name": "p.logo"}).json()
    assert [(each["line"], each["column"], each["kind"]) for each in found] == [(2, 1, "unknown procedure")]
    assert "Did you mean forward?" in found[0]["hint"]
    assert client.post("/api/check", json={"source": "fd 10"}).json() == []
    deep = client.post("/api/check", json={"source": "repeat 2 [" * 9_000 + "]" * 9_000})
    assert deep.status_code == 200
    assert deep.json()[0]["kind"] == "syntax"


def test_words_have_their_inputs_and_a_line_of_help(client: httpx.Client) -> None:
    words = {word["name"]: word for word in client.get("/api/logo/words").json()}
    assert words["fd"] == {
        "name": "fd", "inputs": 1, "fewest": 1, "most": 1, "help": "Drive ahead by so many steps.",
    }  # fmt: skip
    assert words["print"]["most"] == -1
    assert [name for name, word in words.items() if not word["help"]] == []


def test_a_preview_begins_where_the_robot_stands(client: httpx.Client) -> None:
    begin(client, "cs seth 0 fd 30")
    phase(client, "ended")
    wait_until(lambda: client.get("/api/robots/walter").json()["view"]["pose"]["y_mm"] > 29, "the view")
    found = client.post("/api/robots/walter/preview", json={"source": "fd 20", "name": "p.logo"}).json()
    assert found["way"]["top_mm"] == pytest.approx(50, abs=1)
    assert found["way"]["bottom_mm"] == pytest.approx(30, abs=1)


def test_examples_and_kept_programs(client: httpx.Client) -> None:
    names = client.get("/api/examples").json()
    assert "rose.logo" in names
    assert "repeat" in client.get("/api/examples/rose.logo").json()["source"].lower()
    assert client.get("/api/examples/none.logo").status_code == 404

    new = client.put("/api/programs/my own.logo", json={"source": "fd 1"})
    assert new.status_code == 200
    read = client.get("/api/programs/my own.logo")
    assert read.headers["ETag"] == new.headers["ETag"] == read.json()["etag"]
    assert client.get("/api/programs").json()[0]["name"] == "my own.logo"
    clash = client.put("/api/programs/my own.logo", json={"source": "fd 2"})
    assert (clash.status_code, clash.json()["code"]) == (412, "exists")
    saved = client.put(
        "/api/programs/my own.logo", json={"source": "fd 3"}, headers={"If-Match": read.headers["ETag"]}
    )
    assert saved.status_code == 200
    late = client.delete("/api/programs/my own.logo", headers={"If-Match": read.headers["ETag"]})
    assert (late.status_code, late.json()["code"]) == (412, "changed")
    assert client.delete("/api/programs/my own.logo").status_code == 422  # which one is meant must be said
    gone = client.delete("/api/programs/my own.logo", headers={"If-Match": saved.headers["ETag"]})
    assert gone.status_code == 200
    assert client.get("/api/programs").json() == []
    for name in ("..%2Fx.logo", "x.txt", "%2Fetc%2Fpasswd"):
        assert client.put(f"/api/programs/{name}", json={"source": ""}).status_code in (404, 405, 422)
