"""Messages that somebody writes: what they set going ends with whoever sent them, and other hands overtake it."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

import pytest

from tests.unit.console.served import Served, moves, stands, until

if TYPE_CHECKING:
    from collections.abc import Iterator

    import httpx

    from tests.unit.console.served import Page

WALL = """
[[wall]]
points = [[-500, 150], [500, 150]]
"""


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A WALTER with a wall before it, a car, and a two-engine robot."""
    folder = tmp_path_factory.mktemp("console")
    (folder / "wall.toml").write_text(WALL, "utf-8")
    urls = (f"sim:walter?arena={folder / 'wall.toml'}", "sim:simple", "sim:frame")
    with Served(*urls, folder=folder / "programs") as made:
        yield made


@pytest.fixture
def page(served: Served) -> Iterator[Page]:
    """Somebody at a page who drives the three."""
    with served.page("walter", "car", "frame", max_queue=None) as made:  # it is not always read
        for robot in ("walter", "car", "frame"):
            made.say(type="wheel", robot=robot, action="take")
            made.state(robot, lambda state: state["wheel"]["driver"] == made.id)
        yield made
        made.say(type="stop")


@pytest.fixture
def client(served: Served, page: Page) -> Iterator[httpx.Client]:
    """The page's requests."""
    with served.http(**{"X-Session": page.session}) as made:
        made.timeout = 60.0
        yield made


def send(client: httpx.Client, robot: str, text: str) -> httpx.Response:
    return client.post(f"/api/robots/{robot}/messages", json={"text": text})


def place(state: dict[str, Any]) -> tuple[float, float]:
    return state["view"]["pose"]["x_mm"], state["view"]["pose"]["y_mm"]


def test_a_motion_goes_on_until_it_is_done(page: Page, client: httpx.Client) -> None:
    x, y = place(page.state("walter", stands))
    assert send(client, "walter", "back 120").json() == {
        "text": "back distance_half_mm=120",
        "raw": "42 00 78 0D",
    }
    state = page.state("walter", lambda state: stands(state) and place(state) != (x, y))
    state = page.state("walter", lambda state: stands(state) and abs(place(state)[1] - (y - 60.0)) < 1.0)
    assert place(state)[0] == pytest.approx(x, abs=1.0)
    assert state["view"]["notices"] == [] or state["view"]["notices"][-1]["level"] == "note"


def test_it_stops_when_whoever_sent_it_is_gone(served: Served) -> None:
    with served.page("walter") as watcher:
        with served.page("walter") as driver, served.http(**{"X-Session": driver.session}) as client:
            driver.say(type="wheel", robot="walter", action="take")
            driver.state("walter", lambda state: state["wheel"]["driver"] == driver.id)
            assert send(client, "walter", "back 20000").status_code == 200
            watcher.state("walter", moves)
        state = watcher.state("walter", stands)
        x, y = place(state)
        later = watcher.state("walter", lambda later: later["view"]["time_s"] > state["view"]["time_s"] + 1.0)
        assert place(later) == pytest.approx((x, y), abs=1.0)


def test_it_stops_when_its_page_is_hidden(page: Page, client: httpx.Client) -> None:
    send(client, "walter", "back 20000")
    page.state("walter", moves)
    page.say(type="visible", visible=False)
    page.state("walter", stands)


def test_a_hand_overtakes_it(page: Page, client: httpx.Client) -> None:
    send(client, "walter", "back 20000")
    page.state("walter", moves)
    page.hold("walter", 1.0, lambda state: state["view"]["speed_mm_per_s"] > 10.0)
    page.state("walter", stands)


def test_a_key_overtakes_a_motion_and_ends_by_itself(page: Page, client: httpx.Client) -> None:
    send(client, "walter", "back 20000")
    page.state("walter", moves)
    assert send(client, "walter", "start_right").status_code == 200
    page.state("walter", lambda state: abs(state["view"]["turn_deg_per_s"]) > 1.0)
    page.state("walter", stands)


@pytest.mark.parametrize(
    ("robot", "first", "second"),
    [
        ("car", "drive_forward 200", "steer_left 255"),
        ("frame", "engine_forward 0 200; engine_forward 1 200", "engine_forward 1 100"),
    ],
)
def test_what_goes_on_until_told_otherwise_ends_after_two_seconds(
    page: Page, client: httpx.Client, robot: str, first: str, second: str
) -> None:
    assert send(client, robot, first).status_code == 200
    page.state(robot, lambda state: state["view"]["speed_mm_per_s"] > 10.0)
    assert send(client, robot, second).status_code == 200  # while the first goes on
    page.state(robot, lambda state: abs(state["view"]["turn_deg_per_s"]) > 1.0 and moves(state))
    page.state(robot, stands)


def test_a_limit_on_the_way_is_told_to_everybody(page: Page, client: httpx.Client) -> None:
    send(client, "walter", "stop")
    send(client, "walter", "turn_to 0")
    page.state("walter", stands)
    known = {notice["number"] for notice in page.state("walter")["view"]["notices"]}
    assert send(client, "walter", "forward 60000").status_code == 200
    state = page.state(
        "walter", lambda state: {notice["number"] for notice in state["view"]["notices"]} - known
    )
    assert (state["view"]["notices"][-1]["code"], state["view"]["notices"][-1]["sensor"]) == (
        "limit",
        "front",
    )
    send(client, "walter", "back 200")
    page.state("walter", stands)


def test_a_stop_ends_what_waits_for_an_answer(served: Served, page: Page, client: httpx.Client) -> None:
    assert send(client, "walter", "query_y").status_code == 200
    assert client.post("/api/robots/walter/faults/stall", json={"seconds": 5}).json()["stalled_s"] == 5
    answers: list[httpx.Response] = []
    asking = threading.Thread(target=lambda: answers.append(send(client, "walter", "query_x")))
    asking.start()
    with served.http() as other:

        def is_asked() -> bool:
            passed = other.get("/api/robots/walter/traffic?newest=true&limit=20").json()["lines"]
            return "query_x" in [line["text"] for line in passed if line["from"] == "host"]

        until(is_asked)
        other.post("/api/robots/walter/stop")
    asking.join(60.0)
    assert (answers[0].status_code, answers[0].json()["code"]) == (409, "stopped")
    until(lambda: client.get("/api/robots/walter/faults").json()["on"] is False)


@pytest.mark.parametrize(
    ("robot", "text", "status", "code", "details"),
    [
        ("walter", "forwad 200", 422, "bad_message", {"start": 0, "end": 6}),
        ("walter", "forward 70000", 422, "bad_message", {"start": 8, "end": 13}),
        ("walter", "x_reply 3", 422, "bad_message", None),
        ("walter", "select_direct", 422, "bad_message", None),
        ("car", "accepted", 422, "bad_message", None),
        ("frame", "frame seq=3; engine_forward 0 1", 422, "bad_message", None),
        ("frame", "frame", 422, "bad_message", None),
        ("frame", "engine_forward 9 1", 422, "bad_message", None),
    ],
)
def test_what_cannot_be_sent_is_refused_with_its_place(
    client: httpx.Client, robot: str, text: str, status: int, code: str, details: dict[str, int] | None
) -> None:
    answer = send(client, robot, text)
    assert (answer.status_code, answer.json()["code"], answer.json().get("details")) == (
        status,
        code,
        details,
    )


def test_who_does_not_drive_sends_nothing_and_changes_no_faults(served: Served, page: Page) -> None:
    with served.http() as nobody:
        assert send(nobody, "walter", "forward 10").status_code == 401
        other = nobody.post("/api/sessions").json()["session"]
    with served.http(**{"X-Session": other}) as client:
        assert send(client, "walter", "forward 10").json()["code"] == "not_the_driver"
        for path, body in (("", {"lose": 0.1}), ("/stall", {"seconds": 1}), ("/unplug", {"seconds": 1})):
            answer = client.request("POST" if path else "PUT", f"/api/robots/walter/faults{path}", json=body)
            assert (answer.status_code, answer.json()["code"]) == (409, "not_the_driver")
        assert client.get("/api/robots/walter/faults").json()["on"] is False


def test_while_a_program_runs_nothing_is_sent(client: httpx.Client) -> None:
    program = {"source": "repeat 1000 [fd 1 bk 1]"}
    assert client.post("/api/robots/walter/program", json=program).status_code < 300
    try:
        assert send(client, "walter", "forward 10").json()["code"] == "program_runs"
    finally:
        client.post("/api/robots/walter/program/stop")
    until(
        lambda: (
            (client.get("/api/robots/walter").json()["program"] or {}).get("phase") in ("stopped", "ended")
        )
    )


def test_faults_are_changed_at_once(page: Page, client: httpx.Client) -> None:
    wanted = {
        "lose": 0.25,
        "add": 0.0,
        "flip": 0.0,
        "duplicate": 0.0,
        "delay_s": 0.5,
        "split": 3,
        "to": "host",
    }
    now = client.put("/api/robots/frame/faults", json=wanted).json()
    assert {name: now[name] for name in wanted} == wanted
    state = page.state("frame", lambda state: state["faults"]["on"])
    assert state["faults"]["split"] == 3
    assert client.put("/api/robots/frame/faults", json={}).json()["on"] is False
    page.state("frame", lambda state: not state["faults"]["on"])


@pytest.mark.parametrize(
    "faults", [{"lose": 1.1}, {"lose": -0.1}, {"delay_s": 6}, {"split": 65}, {"to": "moon"}, {"x": 1}]
)
def test_faults_that_there_are_not(client: httpx.Client, faults: dict[str, Any]) -> None:
    assert client.put("/api/robots/walter/faults", json=faults).status_code == 422


def test_what_passed_is_told_from_a_number_on(client: httpx.Client) -> None:
    address = "/api/robots/walter/traffic"
    first = client.get(f"{address}?limit=3").json()
    assert ([line["number"] for line in first["lines"]], first["lost"], first["following"]) == (
        [0, 1, 2],
        0,
        3,
    )
    assert client.get(f"{address}?since=3&limit=1").json()["lines"][0]["number"] == 3
    newest = client.get(f"{address}?limit=2&newest=true").json()
    assert newest["lost"] == newest["lines"][0]["number"]
    assert client.get(f"{address}?since={newest['following'] + 1000}").json()["lines"] == []
    recording = client.get(f"{address}/recording")
    assert recording.headers["content-disposition"] == 'attachment; filename="recording.jsonl"'
    assert recording.content.startswith(b'{"format":"turtlewire-capture"')
    names = {message["name"] for message in client.get("/api/robots/car/messages").json()}
    assert names == {"drive_forward", "drive_backward", "steer_left", "steer_right", "stop", "headlights"}


def test_a_text_is_checked_while_it_is_written(client: httpx.Client) -> None:
    def check(robot: str, text: str) -> dict[str, Any]:
        answer: dict[str, Any] = client.post(
            f"/api/robots/{robot}/messages/check", json={"text": text}
        ).json()
        return answer

    assert check("walter", "right 90")["bytes"] == {"text": "right angle_deg=90", "raw": "52 00 5A 0D"}
    for _ in range(2):  # what was checked has no number yet
        assert check("frame", "engine_forward 0 200")["bytes"]["raw"] == "A3 00 03 01 00 C8 8B"
    assert check("walter", "right ninety")["problem"]["start"] == 6
    assert check("walter", "x_reply 3")["bytes"] is None
