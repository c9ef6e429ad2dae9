"""What passes on the wire, seen and sent; and faults on purpose, which everybody sees."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import subprocess
import sys
import threading
import time
import tty
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.catalogue import Frame, Packet

from .conftest import wait_until

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from .conftest import Console, Visitor

    Visit = Callable[..., Visitor]

ROWS = ".tw-line"


@pytest.fixture
def traffic(visit: Visit) -> Visitor:
    """The traffic tab, which has heard something."""
    visitor = visit()
    visitor.tab("traffic")
    visitor.see(ROWS).first.wait_for()
    return visitor


def send(visitor: Visitor, text: str) -> None:
    visitor.see("[name=message]").fill(text)
    visitor.see("[name=message]").press("Enter")


def said(visitor: Visitor) -> list[str]:
    """What the rows that are there say, the oldest first."""
    rows = visitor.see(ROWS).evaluate_all(
        """rows => rows.map(
          (row) => [Number(row.dataset.number), row.querySelector(".tw-line-text").lastChild.textContent],
        )"""
    )
    return [text for _, text in sorted(rows)]


def counted(visitor: Visitor) -> str:
    return visitor.see(".tw-traffic-count").inner_text()


def test_a_message_is_completed_sent_and_seen_with_its_answer(traffic: Visitor, console: Console) -> None:
    line = traffic.see("[name=message]")
    line.press_sequentially("forw")
    traffic.see(".tw-hints button").get_by_text("forward", exact=True).wait_for()
    line.press("Tab")
    line.press_sequentially("100")
    traffic.see("#tw-message-says").get_by_text("46 00 64 0D").wait_for()
    assert "half millimetres" in traffic.see("#tw-message-says").inner_text()
    before = console.view("walter")["pose"]
    line.press("Enter")
    wait_until(lambda: "forward distance_half_mm=100" in said(traffic), "it to be seen")
    wait_until(lambda: any(text.startswith("heading_reply") for text in said(traffic)), "the robot's answer")
    console.wait_for_rest("walter")
    after = console.view("walter")["pose"]
    assert abs(after["x_mm"] - before["x_mm"]) + abs(after["y_mm"] - before["y_mm"]) == pytest.approx(
        50, abs=25
    )
    line.press("ArrowUp")
    assert line.input_value() == "forward 100"


def test_a_mistake_is_marked_at_its_place_and_nothing_is_sent(traffic: Visitor) -> None:
    send(traffic, "forward 7x0")
    mark = traffic.see(".tw-wrong-at mark")
    mark.wait_for()
    assert mark.inner_text() == "7x0"
    assert "is not a whole number" in traffic.see(".tw-wrong").inner_text()
    send(traffic, "select_direct")
    traffic.see(".tw-toast").get_by_text("changes between Logo control and direct control").wait_for()
    assert not any("forward" in text or "select_direct" in text for text in said(traffic))
    traffic.expect("422")


def test_who_does_not_drive_sends_nothing(traffic: Visitor, visit: Visit) -> None:
    other = visit()
    other.button("Take the wheel").click()
    other.page.get_by_text("You drive").wait_for()
    send(traffic, "forward 100")
    traffic.see(".tw-toast").get_by_text("This needs the wheel").wait_for()
    traffic.expect("409")


def test_filter_search_pause_clear(traffic: Visitor) -> None:
    traffic.see(".tw-filter summary").click()
    traffic.see("select[name=sender]").select_option("robot")
    wait_until(lambda: said(traffic) and all("reply" in text for text in said(traffic)), "only the robot's")
    traffic.see("select[name=name]").select_option("heading_reply")
    wait_until(lambda: {text.split()[0] for text in said(traffic)} == {"heading_reply"}, "one kind")
    assert re.fullmatch(r"\d+ of \d+ lines", counted(traffic))
    traffic.see("select[name=sender]").select_option("")
    traffic.see("select[name=name]").select_option("")
    traffic.see("input[name=search]").fill("51 4c")
    wait_until(
        lambda: {text.split()[0] for text in said(traffic)} == {"query_location", "location_reply"}, "bytes"
    )
    traffic.see("input[name=search]").fill("")

    traffic.press("button[name=pause]")
    before = said(traffic)
    send(traffic, "query_towards 10 10")
    wait_until(lambda: re.search(r"\d+ new", counted(traffic)), "something new to be counted")
    assert said(traffic) == before
    traffic.press("button[name=pause]")
    wait_until(lambda: "query_towards x_half_mm=10 y_half_mm=10" in said(traffic), "it to be shown")

    traffic.press("button[name=clear]")
    wait_until(lambda: not said(traffic), "nothing to be left")
    send(traffic, "query_towards 30 30")
    wait_until(lambda: "query_towards x_half_mm=30 y_half_mm=30" in said(traffic), "what is new")
    assert "query_towards x_half_mm=10 y_half_mm=10" not in said(traffic)


def test_it_is_copied_and_saved_and_other_tools_read_it(traffic: Visitor, tmp_path: Path) -> None:
    traffic.press("button[name=clear]")
    send(traffic, "forward 40")
    wait_until(lambda: "forward distance_half_mm=40" in said(traffic), "it to be seen")
    traffic.press("button[name=copy]")
    traffic.see(".tw-toast").get_by_text("Copied").wait_for()
    # What was copied is pasted where text goes.
    traffic.see("[name=message]").fill("")
    traffic.see("[name=message]").focus()
    traffic.page.keyboard.press("Control+v")
    assert "forward distance_half_mm=40" in traffic.see("[name=message]").input_value()
    with traffic.page.expect_download() as saving:
        traffic.see(".tw-traffic-tools a[download]").click()
    path = tmp_path / saving.value.suggested_filename
    saving.value.save_as(path)
    decoded = subprocess.run(
        [sys.executable, "-m", "turtlewire", "decode", "walter", str(path)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert re.search(r"host +\d+ +forward distance_half_mm=40 +# 46 00 28 0D", decoded.stdout)
    assert re.search(r"robot +\d+ +heading_reply", decoded.stdout)


def test_a_row_tells_all_of_itself(traffic: Visitor) -> None:
    traffic.see(ROWS).last.click()
    whole = traffic.see(".tw-line-whole")
    whole.wait_for()
    assert re.search(
        r"(host|robot), \d+\.\d{6} s since the start, \d+ bytes from byte \d+ on", whole.inner_text()
    )


class Chatterbox:
    """Something at a pty that sends frames as fast as a line of 115200 baud carries them."""

    BYTES_PER_S = 11_520

    def __init__(self) -> None:
        self._here, there = pty.openpty()
        tty.setraw(there)
        self.port = os.ttyname(there)
        self._there = there
        self._is_over = threading.Event()

        codec = Frame("telemetry")
        self._piece = b"".join(
            codec.encode(Packet(seq, (codec.parse("odometry 1 2 3"),))) for seq in range(256)
        )
        self._thread = threading.Thread(target=self._talk, daemon=True)
        self._thread.start()

    def _talk(self) -> None:
        os.set_blocking(self._here, False)
        began, sent = time.monotonic(), 0
        while not self._is_over.wait(0.01):
            due = int((time.monotonic() - began) * self.BYTES_PER_S)
            data = (self._piece * 4)[sent % len(self._piece) :][: due - sent]
            with contextlib.suppress(BlockingIOError):
                os.read(self._here, 1 << 16)
            try:
                sent += os.write(self._here, data)
            except BlockingIOError:
                began = time.monotonic() - sent / self.BYTES_PER_S

    def close(self) -> None:
        self._is_over.set()
        self._thread.join()
        os.close(self._here)
        os.close(self._there)


@pytest.fixture
def chatterbox() -> Iterator[Chatterbox]:
    """A robot that never stops talking."""
    made = Chatterbox()
    yield made
    made.close()


def test_a_busy_line_does_not_bog_the_page_down(
    visit: Visit,
    start_console: Callable[..., Console],
    chatterbox: Chatterbox,
    capsys: pytest.CaptureFixture[str],
) -> None:
    own = start_console("--port", f"{chatterbox.port}?protocol=frame&dialect=telemetry&baud=115200&boot_s=0")
    visitor = visit(at=own, robot=own.robots()[0]["name"])
    visitor.tab("traffic")
    visitor.see(ROWS).first.wait_for()
    frames = visitor.page.evaluate(
        """async () => {
          const took = [];
          let then = performance.now();
          for (let number = 0; number < 120; number++) {
            await new Promise((done) => requestAnimationFrame(done));
            took.push(performance.now() - then);
            then = performance.now();
          }
          return took.sort((one, other) => one - other);
        }"""
    )
    with capsys.disabled():
        print(f"\na busy line: frames take {frames[60]:.0f} ms, 9 of 10 up to {frames[108]:.0f} ms")
    assert visitor.see(ROWS).count() < 80, "only what is seen is in the page"
    wait_until(lambda: re.fullmatch(r"\d{4} lines", counted(visitor)), "the list to be long")
    visitor.press("button[name=pause]")
    before = said(visitor)
    wait_until(lambda: re.search(r"\d+ new", counted(visitor)), "more to come")
    assert said(visitor) == before
    visitor.press("button[name=pause]")
    wait_until(lambda: said(visitor) != before, "it to go on")


# ---------------------------------------------------------------------- faults


def test_faults_are_turned_up_seen_by_everybody_and_end(visit: Visit, console: Console) -> None:
    visitor, other = visit(), visit(phone=True, language="sv-SE")
    assert other.see(".tw-banner").count() == 0
    visitor.tab("link")
    slider = visitor.see("input[name=flip]")
    slider.focus()
    for _ in range(7):
        slider.press("ArrowRight")
    other.page.get_by_text("Felen är på").wait_for()
    visitor.see(".tw-faults output").nth(2).filter(has_text="10 %").wait_for()
    wait_until(
        lambda: console.client.get("/api/robots/walter/faults").json()["flip"] == 0.1,
        "the slider to come to rest",
    )
    visitor.tab("traffic")
    send(visitor, "query_heading")
    visitor.see(f"{ROWS}.error").first.wait_for()
    assert console.client.get("/api/robots/walter/faults").json()["flipped"] > 0
    visitor.tab("link")
    visitor.press("button[name=faults-off]")
    other.see(".tw-banner").wait_for(state="detached")
    state = console.client.get("/api/robots/walter/faults").json()
    assert (state["on"], state["flip"]) == (False, 0.0)
    visitor.see(".tw-faults output").nth(2).filter(has_text="none").wait_for()


def test_the_plug_is_pulled_and_everybody_sees_how_it_comes_back(visit: Visit, console: Console) -> None:
    visitor = visit()
    visitor.tab("link")
    visitor.press("button[name=unplug]")
    visitor.page.get_by_text("Unplugged:").wait_for()
    wait_until(lambda: console.view("walter")["link"] == "reconnecting", "the link to be lost")
    wait_until(lambda: console.view("walter")["link"] == "stopped", "the robot to be reached again")
    visitor.tab("traffic")
    wait_until(lambda: "the link is open again" in said(visitor), "the traffic to say so")
    visitor.tab("drive")
    visitor.button("Go on").click()
    wait_until(lambda: console.view("walter")["link"] == "connected", "it to go on")
    with visitor.driving("ArrowUp", lambda: console.moves("walter")):
        pass
