"""The map: what it shows, how it moves, how fast it is, and pictures of it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from .conftest import wait_until

if TYPE_CHECKING:
    from collections.abc import Callable

    import pytest

    from .conftest import Console, Visitor

    Visit = Callable[..., Visitor]

# Walter's colour, and the middle of what has it in the picture, with how much there is of it.
COLOURED = """
() => {
  const canvas = document.querySelector(".tw-map canvas");
  const {width, height} = canvas;
  const {data} = canvas.getContext("2d").getImageData(0, 0, width, height);
  let [count, x, y] = [0, 0, 0];
  for (let i = 0; i < data.length; i += 4) {
    if (Math.abs(data[i] - 0x0b) + Math.abs(data[i + 1] - 0x6e) + Math.abs(data[i + 2] - 0x6e) > 12) continue;
    count += 1;
    x += (i / 4) % width;
    y += Math.floor(i / 4 / width);
  }
  const ratio = window.devicePixelRatio;
  return {count, x: x / count / ratio, y: y / count / ratio};
}
"""
# How long each frame took while something is done again and again, in milliseconds.
FRAMES = """
async ([count, doing]) => {
  const act = {
    pan: (n) => drag(n % 2 ? 9 : -9, 4),
    far: (n) => drag(n < 30 ? 50 : -50, 0),
    zoom: (n) => canvas.dispatchEvent(new WheelEvent("wheel", {deltaY: n % 30 < 15 ? 40 : -40,
      clientX: 400, clientY: 400, bubbles: true, cancelable: true})),
  }[doing];
  const canvas = document.querySelector(".tw-map canvas");
  canvas.setPointerCapture = () => {};
  const send = (type, x, y) => canvas.dispatchEvent(
    new PointerEvent(type, {pointerId: 7, clientX: x, clientY: y, bubbles: true, cancelable: true}));
  let [x, y] = [400, 400];
  const drag = (dx, dy) => send("pointermove", (x += dx), (y += dy));
  if (doing !== "zoom") send("pointerdown", x, y);
  const times = [];
  let before = performance.now();
  for (let n = 0; n < count; n += 1) {
    act(n);
    await new Promise(requestAnimationFrame);
    const now = performance.now();
    times.push(now - before);
    before = now;
  }
  send("pointerup", x, y);
  return times;
}
"""
ARENA = """
[[wall]]
points = [[-200, 260], [200, 260]]
"""


def _seen(visitor: Visitor) -> dict[str, float]:
    visitor.expect("willReadFrequently")  # people do not read the picture back
    seen: dict[str, float] = visitor.page.evaluate(COLOURED)
    return seen


def _wait_for_picture(visitor: Visitor, condition: Callable[[dict[str, float]], bool], what: str) -> None:
    def is_so() -> bool:
        visitor.page.wait_for_timeout(20)
        return condition(_seen(visitor))

    wait_until(is_so, what)


def _shows(visitor: Visitor, least: float) -> bool:
    visitor.page.wait_for_timeout(20)
    return _seen(visitor)["count"] >= least


def _scale(visitor: Visitor) -> str:
    return visitor.see(".tw-scale").inner_text()


def test_the_path_is_drawn_where_the_robot_went(console: Console, visit: Visit) -> None:
    visitor = visit()
    if not console.view("walter")["pen_down"]:
        visitor.press(".tw-equipment button:has-text('Pen')")
        wait_until(lambda: console.view("walter")["pen_down"], "the pen to be down")
    visitor.press(".tw-equipment button:has-text('Clean map')")
    wait_until(lambda: not console.client.get("/api/robots/walter/path").json()["points"][1:], "a clean map")
    visitor.press("[aria-label='Show all']")
    visitor.page.wait_for_timeout(100)
    before = _seen(visitor)
    visitor.page.keyboard.press("9")
    with visitor.driving("ArrowUp", lambda: _shows(visitor, before["count"] + 200)):
        pass
    console.wait_for_rest("walter")
    pose = console.view("walter")["pose"]
    says = visitor.see(".tw-map canvas").get_attribute("aria-label") or ""
    assert f"x {round(pose['x_mm'])}, y {round(pose['y_mm'])} mm" in says
    with_line = _seen(visitor)["count"]
    visitor.press(".tw-equipment button:has-text('Clean map')")
    _wait_for_picture(visitor, lambda seen: seen["count"] < with_line - 150, "the line to go")


def test_zoom_pan_and_show_all(visit: Visit) -> None:
    visitor = visit()
    page = visitor.page
    visitor.press("[aria-label='Show all']")
    _wait_for_picture(visitor, lambda seen: seen["count"] > 0, "the robot")
    first = _scale(visitor)
    for _ in range(4):
        visitor.press("[aria-label='Zoom in']")
    wait_until(lambda: _scale(visitor) != first, "another scale")
    closer = _scale(visitor)
    x, y, _ = visitor.middle(".tw-map canvas")
    page.mouse.move(x, y)
    page.mouse.wheel(0, 1500)
    wait_until(lambda: _scale(visitor) != closer, "the wheel to zoom")
    before = _seen(visitor)
    page.mouse.down()
    page.mouse.move(x + 120, y + 60, steps=5)
    page.mouse.up()
    _wait_for_picture(
        visitor,
        lambda seen: abs(seen["x"] - before["x"] - 120) < 3 and abs(seen["y"] - before["y"] - 60) < 3,
        "the map to be dragged",
    )
    visitor.press("[aria-label='Show all']")
    wait_until(lambda: _scale(visitor) == first, "all to be shown")


def test_by_keyboard(visit: Visit) -> None:
    visitor = visit()
    canvas = visitor.see(".tw-map canvas")
    _wait_for_picture(visitor, lambda seen: seen["count"] > 0, "the robot")
    visitor.press("[aria-label='Show all']")
    visitor.let_timers_run()
    before, scale = _seen(visitor), _scale(visitor)
    canvas.press("ArrowLeft")
    _wait_for_picture(visitor, lambda seen: seen["x"] > before["x"] + 50, "the map to move")
    for _ in range(4):
        canvas.press("-")
    wait_until(lambda: _scale(visitor) != scale, "another scale")
    canvas.press("0")
    wait_until(lambda: _scale(visitor) == scale, "all to be shown")
    assert visitor.see(".tw-wheel-says").inner_text() == "Nobody drives"  # the arrows were the map's


def test_two_fingers_zoom(visit: Visit) -> None:
    visitor = visit(phone=True)
    _wait_for_picture(visitor, lambda seen: seen["count"] > 0, "the robot")
    before = _scale(visitor)
    x, y, _ = visitor.middle(".tw-map canvas")
    visitor.touch("touchStart", (x - 20, y), (x + 20, y))
    for apart in (40, 60, 80):
        visitor.touch("touchMove", (x - apart, y), (x + apart, y))
    visitor.touch("touchEnd")
    wait_until(lambda: _scale(visitor) != before, "another scale")


def test_the_robot_is_followed(console: Console, visit: Visit) -> None:
    visitor = visit()
    if console.view("walter")["pen_down"]:
        visitor.press(".tw-equipment button:has-text('Pen')")  # so that only the robot has its colour
        wait_until(lambda: not console.view("walter")["pen_down"], "the pen to be up")
    visitor.press(".tw-equipment button:has-text('Clean map')")
    follow = visitor.page.get_by_role("button", name="Follow the robot")
    assert follow.get_attribute("aria-pressed") == "true"
    for _ in range(9):
        visitor.press("[aria-label='Zoom in']")
    visitor.page.keyboard.press("9")
    follow.click()
    with visitor.driving("ArrowUp", lambda: not _shows(visitor, 1)):
        follow.click()
        _wait_for_picture(visitor, lambda seen: seen["count"] > 0, "the robot to be followed")
    console.wait_for_rest("walter")
    assert follow.get_attribute("aria-pressed") == "true"


def test_pictures_are_saved(console: Console, visit: Visit) -> None:
    visitor = visit()
    for kind, magic in (("SVG", b"<?xml"), ("PNG", b"\x89PNG\r\n")):
        visitor.press("[aria-label='Save as a picture']")
        with visitor.page.expect_download() as coming:
            visitor.page.get_by_role("link", name=kind).click()
        download = coming.value
        assert download.suggested_filename == f"walter.{kind.lower()}"
        assert Path(download.path()).read_bytes().startswith(magic)


def test_a_limit_is_told_clearly(
    start_console: Callable[..., Console], visit: Visit, tmp_path_factory: pytest.TempPathFactory
) -> None:
    arena = tmp_path_factory.mktemp("arena") / "wall.toml"
    arena.write_text(ARENA, encoding="utf-8")
    other = start_console("--port", f"sim:walter?arena={arena}")
    name = other.robots()[0]["name"]
    visitor = visit(at=other, robot=name)
    visitor.see(".tw-chip:has-text('Limits clear')").wait_for()
    visitor.page.keyboard.press("9")
    toast = visitor.see(".tw-toast.warning:has-text('Limit: Front')")
    with visitor.driving("ArrowUp", lambda: toast.count() > 0):
        other.wait_for_rest(name)
        visitor.see(".tw-hand-says:has-text('in the way')").wait_for()
    visitor.see(".tw-notices li:has-text('Limit: Front')").first.wait_for()
    blocked = visitor.see(".tw-chip.danger:has-text('Front: blocked')")
    blocked.wait_for()
    assert not visitor.see(".tw-chip:has-text('Limits clear')").count()
    with visitor.driving("ArrowDown", lambda: blocked.count() == 0):
        pass
    other.wait_for_rest(name)


def test_frames_with_a_long_path(console: Console, visit: Visit, capsys: pytest.CaptureFixture[str]) -> None:
    """10^5 points; how long the frames take is printed: it depends on the machine, and is not right or wrong."""
    count = 100_000
    points = [
        [
            round(400 * math.cos(n / 900) * (0.2 + n / count), 2),
            round(400 * math.sin(n / 700) + 40 * math.sin(n / 11), 2),
            int(n % 3000 > 200),
        ]
        for n in range(count)
    ]
    body = json.dumps({"generation": 0, "from": 0, "points": points})

    def long_path(visitor: Visitor) -> None:
        visitor.page.route(
            "**/api/robots/walter/path*",
            lambda route: route.fulfill(body=body, content_type="application/json"),
        )

    # the same generation as the server's: its new points do not fit, and are fetched, from here again
    visitor = visit(before=long_path)
    visitor.press("[aria-label='Show all']")
    _wait_for_picture(visitor, lambda seen: seen["count"] > 20_000, "the long path")
    lines = []
    for doing in ("pan", "far", "zoom"):
        times: list[Any] = sorted(visitor.page.evaluate(FRAMES, [60, doing]))
        lines.append(f"{doing} {median(times):.1f} ms, 95 % {times[len(times) * 95 // 100]:.1f} ms")
    with capsys.disabled():
        print(f"\nframes with {count:,} points: {'; '.join(lines)}")
