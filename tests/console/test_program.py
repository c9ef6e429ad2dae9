"""Programs in the console, as somebody writes, mends, looks ahead, runs, steps through and stops them."""

from __future__ import annotations

import re
from importlib.resources import files
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from .conftest import DEADLINE_S, Console, Visitor, wait_until
from .test_page import AXE

if TYPE_CHECKING:
    from collections.abc import Callable

    Visit = Callable[..., Visitor]

expect.set_options(timeout=DEADLINE_S * 1000)
CONTENT = ".tw-editor .cm-content"
RUNS = ".tw-editor .cm-line.tw-line-runs"
PHASE = ".tw-phase"
OUTPUT = "[data-part=output]"


def act(name: str) -> str:
    return f"[data-act={name}]"


def write(visitor: Visitor, text: str) -> None:
    """Put a text in the place of what is in the editor, as somebody who pastes it."""
    visitor.press(CONTENT)
    visitor.page.keyboard.press("Control+a")
    visitor.page.keyboard.insert_text(text)


def phase(visitor: Visitor, name: str) -> None:
    expect(visitor.see(f"{PHASE}.{name}")).to_be_visible()


@pytest.fixture(scope="module")
def shared_console(start_console: Callable[..., Console]) -> Console:
    """One of our own: where its robots stand is of what is tested here."""
    return start_console()


@pytest.fixture
def program(visit: Visit) -> Visitor:
    """Somebody on the program tab."""
    visitor = visit()
    visitor.tab("program")
    visitor.see(CONTENT).wait_for()
    return visitor


def test_a_mistake_is_marked_mended_looked_ahead_at_and_run(program: Visitor, console: Console) -> None:
    write(program, "to corner :size\n  foward :size\n  rt 90\nend\nrepeat 4 [corner 30]\nprint [all done]\n")
    mark = program.see(".tw-finding.warning")
    expect(mark).to_have_text("foward")
    finding = program.see("[data-part=findings] li")
    expect(finding).to_contain_text("I don't know how to foward")
    expect(finding).to_contain_text("Did you mean forward?")
    mark.hover()
    expect(program.see(".tw-tip")).to_contain_text("Did you mean forward?")

    program.press("[data-part=findings] button")  # the cursor is there now
    program.page.keyboard.press("ArrowRight")
    program.page.keyboard.press("ArrowRight")
    program.page.keyboard.type("r")
    expect(program.see(f"{CONTENT} .cm-line").nth(1)).to_have_text("  forward :size")
    expect(mark).to_have_count(0)
    expect(finding).to_have_count(0)

    program.press(act("preview"))
    expect(program.see("[data-row=drawing]")).to_have_text("30 × 30 mm")
    expect(program.see("[data-row=path]")).to_have_text("0.12 m, 0.12 m of it with the pen down")
    expect(program.see("[data-row=takes]")).to_have_text(re.compile(r"^\d+\.\d s$"))
    assert not console.moves("walter")

    before = console.view("walter")["distance_mm"]
    program.page.evaluate(
        """() => { window.seen = []; new MutationObserver(() => {
             const line = document.querySelector('.tw-line-runs');
             if (line && window.seen.at(-1) !== line.textContent) window.seen.push(line.textContent);
           }).observe(document.querySelector('.tw-editor'), {subtree: true, childList: true, attributes: true}); }"""
    )
    program.press(act("run"))
    phase(program, "ended")
    expect(program.see(OUTPUT)).to_have_text("all done\n")
    seen = program.page.evaluate("window.seen")
    assert seen.count("  forward :size") >= 3  # the mark follows
    assert seen.count("  rt 90") >= 3
    expect(program.see(RUNS)).to_have_count(0)
    assert console.view("walter")["distance_mm"] - before == pytest.approx(120, abs=5)


def test_stepping_breakpoints_variables_and_a_look_around(program: Visitor) -> None:
    write(program, 'to twice :n\n  print :n\n  output 2 * :n\nend\nmake "k twice 4\nprint :k\nprint "end\n')
    program.press(act("step-first"))
    phase(program, "paused")
    line = program.see(RUNS)
    expect(line).to_have_text('make "k twice 4')
    program.press(act("into"))
    expect(line).to_have_text("  print :n")
    expect(program.see("[data-part=variables]")).to_contain_text(":n")
    program.see("[data-part=here]").fill("print (list :n [look])")
    program.page.keyboard.press("Enter")
    expect(program.see(OUTPUT)).to_have_text("4 [look]\n")
    program.press(act("over"))
    expect(line).to_have_text("  output 2 * :n")
    expect(program.see(OUTPUT)).to_have_text("4 [look]\n4\n")
    program.press(act("out"))
    expect(line).to_have_text("print :k")
    # A breakpoint, by the key; the mouse has the gutter.
    program.see(f"{CONTENT} .cm-line").nth(6).click()
    program.page.keyboard.press("F9")
    expect(program.see(".tw-dot").last).to_be_visible()
    program.press(act("continue"))
    expect(line).to_have_text('print "end')
    expect(program.see(OUTPUT)).to_have_text("4 [look]\n4\n8\n")
    program.press(act("continue"))
    phase(program, "ended")


def test_pause_while_the_robot_draws_and_go_on(program: Visitor, console: Console) -> None:
    write(program, "repeat 40 [fd 20 rt 9]")
    program.press(act("run"))
    console.wait_for_motion("walter")
    program.press(act("pause"))
    phase(program, "paused")
    console.wait_for_rest("walter")
    at = console.view("walter")["pose"]
    program.press(act("into"))
    wait_until(lambda: console.view("walter")["pose"] != at, "a step")
    phase(program, "paused")
    program.press(act("continue"))
    console.wait_for_motion("walter")
    program.press(act("end"))
    phase(program, "stopped")
    console.wait_for_rest("walter")
    assert program.see(".tw-wheel.mine").count()  # ending one's own program is not giving up the wheel


def test_stop_ends_a_program_that_goes_on_for_ever(program: Visitor, console: Console) -> None:
    for source in ("forever []", 'forever [print "flood]', "forever [fd 1 bk 1]"):
        write(program, source)
        program.press(act("run"))
        phase(program, "running")
        assert console.client.get("/api/robots").elapsed.total_seconds() < 5  # and it answers
        program.press(".tw-stop")
        phase(program, "stopped")
        console.wait_for_rest("walter")
        assert console.state("walter")["wheel"]["driver"] is None
    assert len(program.see(OUTPUT).inner_text()) <= 20_000 if program.see(OUTPUT).count() else True


def test_what_a_program_asks_somebody_types(program: Visitor) -> None:
    write(program, 'type [your name?\\ ]\nmake "name readword\nprint (list "Hello :name)\n')
    program.press(act("run"))
    phase(program, "asking")
    expect(program.see("[data-part=input]")).to_be_focused()
    program.page.keyboard.type("Åsa B")
    program.page.keyboard.press("Enter")
    phase(program, "ended")
    expect(program.see(OUTPUT)).to_contain_text("Hello Åsa B")


def test_an_error_is_told_with_its_number_and_marked_at_its_place(program: Visitor) -> None:
    write(program, "to half :n\n  output :n / 0\nend\nfd 10\nprint half 7\n")
    program.press(act("run"))
    phase(program, "failed")
    error = program.see("[data-part=error]")
    expect(error).to_contain_text("/ doesn't like 0 as input in half")
    expect(error).to_contain_text("Line 2")
    expect(error).to_contain_text("error 4")
    expect(program.see(".tw-finding.error")).to_have_text("/")
    # And so that everybody can read it, in all of its colours.
    write(program, 'to half :n ; unused\n  print (list "a :b 1.5 * [c])\nend\nfoward 1\n')
    expect(program.see("[data-part=findings] li")).to_have_count(3)
    program.page.evaluate((files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8"))
    for theme in ("light", "dark"):
        program.choose("theme", theme)
        assert program.page.evaluate(AXE) == []


def test_a_program_outlives_the_page_that_began_it(program: Visitor, visit: Visit, console: Console) -> None:
    write(program, "to side\n  fd 300\n  bk 300\nend\nforever [side]\n")
    program.press(act("run"))
    expect(program.see(RUNS)).to_be_visible()
    other = visit()
    other.tab("program")
    # The other page has written nothing of its own, and so sees what runs, and where.
    expect(other.see(CONTENT)).to_contain_text("to side")
    expect(other.see(RUNS)).to_have_text(re.compile(r"^  (fd|bk) 300$"))
    expect(other.see(act("pause"))).to_be_disabled()
    program.page.reload()
    program.tab("program")
    phase(program, "running")
    expect(program.see(RUNS)).to_have_text(re.compile(r"^  (fd|bk) 300$"))
    other.press(".tw-stop")  # anyone may
    phase(program, "stopped")
    phase(other, "stopped")
    console.wait_for_rest("walter")


def test_saving_and_opening_and_nobody_loses_anything(program: Visitor, visit: Visit) -> None:
    write(program, "fd 10 ; mine\n")
    program.see("[data-part=name]").fill("spiral-ö")
    program.press(act("save"))
    expect(program.see(".tw-toast.good")).to_contain_text("spiral-ö.logo is saved")
    expect(program.see(".tw-unsaved")).to_have_count(0)

    other = visit()
    other.tab("program")
    other.press(act("open"))
    other.button("spiral-ö.logo").click()
    expect(other.see(CONTENT)).to_have_text("fd 10 ; mine")
    write(other, "fd 20 ; theirs\n")
    other.press(act("save"))
    expect(other.see(".tw-toast.good")).to_contain_text("is saved")

    program.expect("412")
    write(program, "fd 30 ; mine again\n")
    program.press(act("save"))
    expect(program.see("#tw-question")).to_have_text("Not saved")
    program.press("[data-answer=theirs]")
    expect(program.see(CONTENT)).to_have_text("fd 20 ; theirs")

    program.press(act("open"))
    program.see("[data-part=programs]").get_by_role("button", name="Delete spiral-ö.logo").click()
    program.press("[data-answer=delete]")
    expect(program.see("[data-part=programs] li")).to_have_count(0)


def test_examples_and_changes_that_are_not_left_unasked(program: Visitor) -> None:
    write(program, "fd 1\n")
    program.press(act("open"))
    program.see("[data-part=examples]").get_by_role("button", name="rose.logo").click()
    expect(program.see("#tw-question")).to_have_text("Leave your changes?")
    program.press("[data-answer=leave]")
    expect(program.see("[data-part=name]")).to_have_value("rose.logo")
    expect(program.see(".tw-findings")).to_have_count(0)
    program.press(act("preview"))
    expect(program.see("[data-row=drawing]")).to_contain_text("mm")


def test_words_are_completed_with_their_inputs_and_help(program: Visitor) -> None:
    write(program, "to zigzag :width\n  fd 1\nend\n")
    expect(program.see(".tok-typeName")).to_have_text("fd")  # it knows Logo's words by now
    program.page.keyboard.press("Control+End")
    program.page.keyboard.type("setpo")
    proposals = program.see(".cm-tooltip-autocomplete li")
    expect(proposals).to_have_count(1)
    expect(proposals).to_have_text("setpos1 to 2 inputs")
    expect(program.see(".cm-completionInfo")).to_contain_text("Drive straight to a place")
    program.page.wait_for_timeout(120)  # CodeMirror takes no key of somebody who could not have read yet
    program.page.keyboard.press("Enter")
    program.page.keyboard.type(" [0 0")
    program.page.keyboard.press("End")
    program.page.keyboard.press("Enter")
    program.page.keyboard.type("zigz")
    expect(proposals).to_contain_text("zigzag:width")
    program.page.wait_for_timeout(120)
    program.page.keyboard.press("Enter")
    expect(program.see(f"{CONTENT} .cm-line").nth(3)).to_have_text("setpos [0 0]")
    expect(program.see(f"{CONTENT} .cm-line").nth(4)).to_have_text("zigzag")


def test_in_the_editor_space_is_a_space_and_escape_stops(program: Visitor, console: Console) -> None:
    write(program, "forever [fd 100 bk 100]")
    program.press(act("run"))
    console.wait_for_motion("walter")
    program.press(CONTENT)
    program.page.keyboard.press("Control+End")
    program.page.keyboard.type(" ; a b")
    assert console.state("walter")["program"]["phase"] == "running"
    program.page.keyboard.press("Escape")
    phase(program, "stopped")
    console.wait_for_rest("walter")


def test_who_does_not_drive_cannot_run(program: Visitor, visit: Visit, console: Console) -> None:
    other = visit()
    other.press(".tw-wheel .primary")
    expect(other.see(".tw-wheel.mine")).to_be_visible()
    write(program, "fd 10")
    program.press(act("run"))
    program.see(".tw-toast").get_by_text("Somebody else drives").wait_for()
    state = console.state("walter")["program"]
    assert state is None or state["phase"] in ("ended", "failed", "stopped")


def test_by_finger_on_a_phone_in_swedish(visit: Visit, console: Console) -> None:
    visitor = visit(phone=True, dark=True, language="sv-SE", robot="car")
    visitor.tab("program")
    visitor.see(CONTENT).wait_for()
    lines = "\n".join(f"; rad {number}" for number in range(1, 40))
    write(visitor, f"{lines}\nrepeat 2 [\n  fd 150\n  bk 150\n]\n")
    visitor.press(act("preview"))
    expect(visitor.see("[data-part=preview]")).to_contain_text("Vad det skulle göra")
    visitor.press(act("run"))
    expect(visitor.see(RUNS)).to_be_in_viewport()  # the editor has scrolled there
    expect(visitor.see(PHASE)).to_contain_text("Körs, rad 4")
    visitor.press(".tw-stop")
    phase(visitor, "stopped")
    expect(visitor.see(PHASE)).to_have_text("Stoppat")
    console.wait_for_rest("car")
