"""The stream and the routes, over real sockets, with simulated robots behind their links."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import pytest
from websockets.exceptions import ConnectionClosed

from tests.unit.console.served import Served, moves, stands, until
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from turtlewire.console.station import Station

ROBOTS = ("walter", "car", "frame")


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with Served("sim:walter", "sim:simple", "sim:frame", folder=tmp_path_factory.mktemp("p")) as served:
        yield served


@pytest.fixture(autouse=True)
def _alone(served: Served) -> Iterator[None]:
    """Each test finds the robots standing, and nobody at a wheel."""
    yield
    stations = list(served.console.stations)
    until(lambda: not any(station.wheel.driver or station.watchers for station in stations))
    until(lambda: not any(station.view.speed_mm_per_s for station in stations))


def station(served: Served, robot: str) -> Station:
    return served.console.stations[robot]


# ---------------------------------------------------------------------- driving


@pytest.mark.parametrize("robot", ROBOTS)
def test_whoever_holds_drives_and_letting_go_stops(served: Served, robot: str) -> None:
    with served.page(robot) as page:
        before = page.state(robot)["view"]["pose"]
        state = page.hold(robot, 0.5, moves)
        assert state["wheel"]["driver"] == page.id
        assert state["view"]["pose"] != before
        page.say(type="release", robot=robot)
        page.state(robot, stands)
        assert page.state(robot, stands)["refused"] is None  # the same grip may go on: nothing has ended it
        page.say(type="stop", robot=robot)


def test_without_set_points_it_stops_by_itself(served: Served) -> None:
    with served.page("frame") as page:
        page.hold("frame", 0.5, moves)
        page.state("frame", stands)
        page.drive("frame", 0.5)
        assert page.refusal("ended")["grip"] == 1
        page.hold("frame", 0.5, moves, grip=2)
        page.say(type="stop", robot=None)


def test_a_page_that_goes_away_while_it_drives_stops_its_robot(served: Served) -> None:
    with served.page("walter") as page:
        page.hold("walter", 0.5, moves)
    found = station(served, "walter")
    until(lambda: found.wheel.driver is None)
    helm = found._helm
    assert helm is not None
    until(lambda: helm._wish.until == -math.inf)  # at once, not when its set-points are too old
    until(lambda: found.view.speed_mm_per_s == 0)


def test_a_page_that_is_not_seen_does_not_drive(served: Served) -> None:
    with served.page("frame") as page:
        page.hold("frame", 0.5, moves)
        page.say(type="visible", visible=False)
        state = page.state("frame", lambda state: state["refused"] == 1)
        page.drive("frame", 0.5)
        page.refusal("ended")
        page.state("frame", stands)
        assert state["wheel"]["driver"] == page.id
        page.say(type="stop", robot="frame")


def test_old_set_points_are_dropped_and_told_once(served: Served) -> None:
    with served.page("frame") as page:
        for _ in range(20):
            page.drive("frame", 0.5, stamp_s=1.0)
        page.drive("frame", 2.0)  # not a message at all: it marks the end
        refusals = [page.await_(lambda m: m["type"] == "refused") for _ in range(2)]
        assert sorted(refusal["code"] for refusal in refusals) == ["late", "message"]
        assert page.state("frame")["wheel"]["driver"] is None
        page.number = 3
        page.drive("frame", 0.5)
        page.refusal("order")


def test_somebody_elses_stop_takes_the_wheel_away(served: Served) -> None:
    with served.page("frame") as driver, served.page("frame") as other:
        driver.hold("frame", 0.5, moves)
        other.say(type="stop", robot="frame")
        state = driver.state("frame", lambda state: state["refused"] == 1)
        assert state["wheel"]["driver"] is None
        assert state["wheel"]["barred"] == [driver.id]
        driver.drive("frame", 0.5, grip=2)
        driver.refusal("wheel_taken_away")
        driver.say(type="wheel", robot="frame", action="take")
        driver.state("frame", lambda state: state["wheel"]["driver"] == driver.id)
        driver.hold("frame", 0.5, moves, grip=3)
        driver.say(type="stop", robot="frame")


def test_one_drives_and_hands_the_wheel_over(served: Served) -> None:
    with served.page("walter") as anna, served.page("walter") as bert:
        anna.say(type="name", name="  Anna\u202e \n")
        anna.hold("walter", 0.5, moves)
        bert.drive("walter", 0.5)
        bert.refusal("wheel_held")
        bert.say(type="wheel", robot="walter", action="ask")
        asked = anna.hold("walter", 0.5, lambda state: state["wheel"]["asker"] == bert.id)
        assert asked["wheel"]["driver_name"] == "Anna"
        anna.say(type="wheel", robot="walter", action="give", to=bert.id)
        bert.state("walter", lambda state: state["wheel"]["driver"] == bert.id)
        # what she still holds does not drive any more
        anna.drive("walter", 0.5)
        anna.refusal("not_the_driver")
        bert.state("walter", stands)
        anna.say(type="wheel", robot="walter", action="give")
        assert anna.refusal("not_the_driver")["what"] == "wheel"
        bert.say(type="stop", robot="walter")


def test_the_path_comes_piece_by_piece(served: Served) -> None:
    with served.page("frame") as page:
        page.hold("frame", 0.5, moves)
        page.state("frame", stands)
        page.say(type="stop", robot="frame")
        page.state("frame", lambda state: state["wheel"]["driver"] is None)
        with served.http() as http:
            whole = http.get("/api/robots/frame/path").json()
            assert whole["from"] == 0
            part = http.get("/api/robots/frame/path", params={"since": 1}).json()
        assert part["points"] == whole["points"][1:]
        shown: list[Any] = []
        for message in page.heard:
            if message["type"] == "state" and (path := message.get("path")):
                if path["generation"] != whole["generation"] or path["from"] > len(shown):
                    shown = whole["points"][: path["from"]]
                shown[path["from"] :] = path["points"]
        assert shown == whole["points"]
        assert len(shown) >= 2


def test_what_passes_on_the_wire_is_told_when_it_is_wanted(served: Served) -> None:
    with served.page("frame") as page:
        page.say(type="traffic", on=True)
        page.hold("frame", 0.4, moves)
        message = page.await_(lambda m: m["type"] == "traffic")
        assert message["robot"] == "frame"
        assert "engine_forward" in json.dumps(message["lines"])
        page.say(type="stop", robot="frame")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"type": "fly"}',
        '{"type": "watch", "robot": 3}',
        '{"type":"stop","more":1}',
        "\u00e5" * 3,
    ],
)
def test_what_is_no_message_is_refused_and_the_stream_goes_on(served: Served, text: str) -> None:
    with served.page("car") as page:
        page.socket.send(text)
        page.refusal("message")
        page.say(type="watch", robot="nobody")
        page.refusal("no_robot")


def test_long_messages_and_floods(served: Served, caplog: pytest.LogCaptureFixture) -> None:
    with served.page("car") as page:
        page.say(type="name", name="x" * 5000)
        page.refusal("long")
        assert page.ended_by('{"type":"visible","visible":true}', 1500) == 1008
    with served.page("car") as page:
        assert page.ended_by("x" * 100_000, 1) == 1009
    until(lambda: "refused 127.0.0.1 WEBSOCKET /api/stream: size: " in caplog.text)
    assert ": too many messages" in caplog.text


def test_there_is_an_end_of_sessions(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("turtlewire.console.sessions.MAX_SESSIONS", 0)
    with pytest.raises(ConnectionClosed) as closed, served.page("car"):
        pass
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1013
    with served.http() as http:
        assert http.post("/api/sessions").json()["code"] == "many_sessions"


def test_sessions_that_nobody_uses_are_over(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    with served.http() as http:
        one = http.post("/api/sessions").json()
        headers = {"X-Session": one["session"]}
        assert http.post("/api/robots/car/wheel", json={"action": "take"}, headers=headers).is_success
        monkeypatch.setattr("turtlewire.console.sessions.UNUSED_S", 0.0)
        with served.page("car") as page:
            page.state("car")
            http.post("/api/sessions")
            assert page.state("car", lambda state: state["wheel"]["driver"] is None)
        answer = http.post("/api/robots/car/wheel", json={"action": "take"}, headers=headers)
        assert answer.json()["code"] == "no_session"


def test_a_stop_is_heard_in_the_middle_of_a_flood(served: Served) -> None:
    with served.page("frame") as driver, served.page("frame") as other:
        driver.hold("frame", 0.5, moves)
        for _ in range(300):
            other.say(type="visible", visible=True)
        other.say(type="stop", robot="frame")
        driver.state("frame", lambda state: state["wheel"]["driver"] is None)


# ---------------------------------------------------------------------- for machines


def test_a_program_of_somebody_drives_by_requests(served: Served) -> None:
    with served.http() as http:
        opened = http.post("/api/sessions", json={"name": "a program"})
        assert opened.status_code == 201
        http.headers["X-Session"] = opened.json()["session"]
        assert [robot["name"] for robot in http.get("/api/robots").json()] == list(ROBOTS)
        command = {"command": "pen", "value": False}
        refused = http.post("/api/robots/walter/commands", json=command)
        assert (refused.status_code, refused.json()["code"]) == (409, "not_the_driver")
        wheel = http.post("/api/robots/walter/wheel", json={"action": "take"}).json()
        assert wheel["driver"] == opened.json()["id"]
        assert wheel["driver_name"] == "a program"
        assert http.post("/api/robots/walter/commands", json=command).status_code == 202
        until(lambda: http.get("/api/robots/walter").json()["view"]["pen_down"] is False)
        assert http.post("/api/robots/walter/commands", json={"command": "pen"}).status_code == 202
        until(lambda: http.get("/api/robots/walter").json()["view"]["pen_down"] is True)
        assert http.post("/api/robots/walter/commands", json={"command": "lamp", "value": True}).is_success
        until(lambda: http.get("/api/robots/walter").json()["view"]["lamp"] is True)
        assert http.post("/api/robots/walter/stop").json() == {"ok": True}
        assert http.get("/api/robots/walter").json()["wheel"]["driver"] is None
        http.post("/api/robots/car/wheel", json={"action": "take"})
        assert http.post("/api/stop").is_success
        assert http.get("/api/robots/car").json()["wheel"]["driver"] is None


def test_a_clean_sheet(served: Served) -> None:
    with served.page("frame") as page, served.http() as http:
        page.hold("frame", 0.6, lambda state: state["view"]["distance_mm"] > 20)
        http.headers["X-Session"] = page.session
        page.say(type="release", robot="frame")
        page.state("frame", stands)
        before = http.get("/api/robots/frame/path").json()
        assert http.post("/api/robots/frame/commands", json={"command": "clean"}).is_success
        after = until(
            lambda: (
                (path := http.get("/api/robots/frame/path").json())["generation"] > before["generation"]
                and path
            )
        )
        assert len(after["points"]) < len(before["points"])
        assert http.post("/api/robots/frame/stop").is_success


@pytest.mark.parametrize("robot", ROBOTS)
def test_pictures(served: Served, robot: str) -> None:
    with served.http() as http:
        svg = http.get(f"/api/robots/{robot}/picture.svg")
        assert svg.headers["content-type"] == "image/svg+xml"
        assert svg.text.rstrip().endswith("</svg>")
        png = http.get(f"/api/robots/{robot}/picture.png")
        assert png.content.startswith(b"\x89PNG")
        assert http.get(f"/api/robots/{robot}/picture.gif").status_code == 422


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "code"),
    [
        ("GET", "/api/robots/nobody", None, 404, "no_robot"),
        ("POST", "/api/robots/nobody/stop", None, 404, "no_robot"),
        ("GET", "/api/nothing", None, 404, "no_such_page"),
        ("GET", "/api/stop", None, 405, "method"),
        ("GET", "/api/robots/car/path?since=-1", None, 422, "invalid"),
        ("GET", "/api/robots/car/path?since=x", None, 422, "invalid"),
        ("POST", "/api/robots/car/wheel", {"action": "take"}, 401, "no_session"),
        ("POST", "/api/robots/car/commands", {"command": "pen"}, 401, "no_session"),
        ("POST", "/api/sessions", {"nom": "x"}, 422, "invalid"),
        ("POST", "/api/sessions", {"name": "x" * 1000}, 422, "invalid"),
    ],
)
def test_what_is_refused_says_why(
    served: Served, method: str, path: str, body: Any, status: int, code: str
) -> None:
    with served.http() as http:
        answer = http.request(method, path, json=body)
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert answer.json()["text"]


@pytest.mark.parametrize(
    "command",
    [
        {"command": "lamp", "value": "on"},
        {"command": "lamp", "value": 1},
        {"command": "key", "value": "fly"},
        {"command": "key"},
        {"command": "clean", "value": True},
        {"command": "explode"},
    ],
)
def test_commands_that_mean_nothing(served: Served, command: dict[str, Any]) -> None:
    with served.page("car") as page, served.http(**{"X-Session": page.session}) as http:
        http.post("/api/robots/car/wheel", json={"action": "take"})
        answer = http.post("/api/robots/car/commands", json=command)
    assert answer.status_code == 422
    assert answer.json()["text"]


def test_the_api_describes_itself(served: Served) -> None:
    with served.http() as http:
        described = http.get("/api/openapi.json").json()
        assert http.get("/docs").status_code == 404  # which would load files of another host
    assert {"/api/robots", "/api/robots/{robot}/wheel", "/api/stop"} <= set(described["paths"])


def test_twenty_who_watch_are_told_the_same(served: Served) -> None:
    with served.page("frame") as driver:
        watchers = [served.page("frame") for _ in range(20)]
        pages = [watcher.__enter__() for watcher in watchers]
        state = driver.hold("frame", 0.5, lambda state: state["wheel"]["watchers"] == 21 and moves(state))
        for page in pages:
            seen = page.state("frame", lambda seen: seen["wheel"]["driver"] == driver.id and moves(seen))
            assert seen["view"]["pose"]["y_mm"] >= 0 or state
        driver.say(type="stop", robot="frame")
        for watcher in watchers:
            watcher.__exit__(None, None, None)


def test_when_it_ends_nobody_drives_on(tmp_path: Path) -> None:
    with Served("sim:frame", folder=tmp_path) as served, served.page("frame") as page:
        page.hold("frame", 0.5, moves)
        served.console.stations.end()
        page.state("frame", stands)
        page.drive("frame", 0.5, grip=2)
        page.refusal("over")


def test_a_long_path_is_fetched_and_told(tmp_path: Path) -> None:
    with Served("sim:frame", folder=tmp_path) as served, served.page("frame") as page:
        path = served.console.stations["frame"].path
        for i in range(5000):
            path.move(Pose(100.0 * (i % 2), float(i)), pen_down=bool(i % 3))
        whole = path.since(0)
        assert len(whole.points) >= 5000
        shown: list[Any] = whole.points[:1]
        while len(shown) < len(whole.points):
            piece = page.state("frame", lambda state: "path" in state)["path"]
            assert len(piece["points"]) <= 2000
            shown[piece["from"] :] = [tuple(point) for point in piece["points"]]
        assert shown == whole.points
        with served.http() as http:
            fetched = http.get("/api/robots/frame/path").json()["points"]
        assert [tuple(point) for point in fetched] == whole.points
