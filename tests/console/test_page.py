"""The page as a whole: for everybody (axe finds nothing), both languages, every size; and its link tab."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING, Any

import pytest

from .conftest import wait_until

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Console, Visitor

    Visit = Callable[..., Visitor]

TABS = ("drive", "program", "traffic", "link")
# All that it finds, however small: the levels A and AA of WCAG, and what axe itself thinks best.
AXE = """
async () => {
  const {violations} = await axe.run(document, {resultTypes: ["violations"]});
  return violations
    .map(({id, help, nodes}) => `${id}: ${help}: ${nodes.map(({html, any}) => html.slice(0, 200) + " " +
      any.map(({message}) => message).join("; ")).join(" | ")}`);
}
"""
# Where the page's modules are: the folder that has its style sheet.
TEXTS = """
async () => {
  const {TEXTS} = await import(new URL("texts.js", document.querySelector("link[href$='console.css']").href));
  return TEXTS;
}
"""
# The page's streams, so that a test can end one as a network does.
SOCKETS = """
window.sockets = [];
window.WebSocket = class extends WebSocket {
  constructor(url, ...more) {
    super(url, ...more);
    if (String(url).includes("/api/stream")) window.sockets.push(this);
  }
};
"""


@pytest.mark.parametrize("phone", [False, True], ids=["desktop", "phone"])
def test_everybody_can_use_it(visit: Visit, phone: bool) -> None:
    visitor = visit(phone=phone)
    visitor.page.evaluate((files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8"))
    found: list[str] = []
    for language, theme in (("en", "light"), ("en", "dark"), ("sv", "dark"), ("sv", "light")):
        visitor.choose("language", language)
        visitor.choose("theme", theme)
        for tab in TABS:
            visitor.tab(tab)
            assert visitor.see(f"#tw-tab-{tab}").get_attribute("aria-selected") == "true"
            found += [f"{tab}, {theme}, {language}: {each}" for each in visitor.page.evaluate(AXE)]
    visitor.press(".tw-head [aria-label='Inställningar']")
    found += visitor.page.evaluate(AXE)
    assert found == [], "\n".join(found)


def test_every_text_is_there_in_both_languages(visit: Visit) -> None:
    texts: dict[str, dict[str, str]] = visit().page.evaluate(TEXTS)
    assert sorted(texts) == ["en", "sv"]
    assert texts["en"].keys() == texts["sv"].keys()
    for key, text in texts["en"].items():
        places = {piece.split("}")[0] for piece in text.split("{")[1:]}
        assert {piece.split("}")[0] for piece in texts["sv"][key].split("{")[1:]} == places, key
        assert text, key


def test_the_browsers_language_and_another(visit: Visit) -> None:
    visitor = visit(language="sv-SE")
    assert visitor.see("#tw-tab-drive").inner_text() == "Kör"
    assert visitor.see("html").get_attribute("lang") == "sv"
    visitor.choose("language", "en")
    assert visitor.see("#tw-tab-drive").inner_text() == "Drive"
    visitor.page.reload()
    visitor.see("#tw-tab-drive:has-text('Drive')").wait_for()  # it is kept


@pytest.mark.parametrize("dark", [False, True])
def test_the_devices_colours_and_others(visit: Visit, dark: bool) -> None:
    visitor = visit(dark=dark)
    body = "() => document.body.classList.contains('body--dark')"
    assert visitor.page.evaluate(body) is dark
    visitor.choose("theme", "light" if dark else "dark")
    assert visitor.page.evaluate(body) is not dark


def test_tabs_by_keyboard(visit: Visit) -> None:
    visitor = visit()
    visitor.see("#tw-tab-drive").press("ArrowLeft")
    assert visitor.see("#tw-tab-link").get_attribute("aria-selected") == "true"
    visitor.page.keyboard.press("Home")
    assert visitor.see("#tw-tab-drive").get_attribute("aria-selected") == "true"


def _overlap(one: dict[str, Any], other: dict[str, Any]) -> bool:
    return bool(
        one["x"] < other["x"] + other["width"]
        and other["x"] < one["x"] + one["width"]
        and one["y"] < other["y"] + other["height"]
        and other["y"] < one["y"] + one["height"]
    )


def test_the_stop_is_always_in_reach(visit: Visit) -> None:
    visitor = visit()
    for width, height in ((1280, 800), (390, 780), (320, 568), (780, 360)):
        visitor.page.set_viewport_size({"width": width, "height": height})
        for tab in TABS:
            visitor.tab(tab)
            stop = visitor.see(".tw-stop").bounding_box()
            assert stop is not None
            assert min(stop["width"], stop["height"]) >= 44
            assert stop["x"] >= 0 <= stop["y"]
            assert stop["x"] + stop["width"] <= width
            assert stop["y"] + stop["height"] <= height
            tabs = [visitor.see(f"#tw-tab-{each}").bounding_box() for each in TABS]
            assert not any(each is not None and _overlap(dict(stop), dict(each)) for each in tabs)
            assert visitor.page.evaluate("document.documentElement.scrollWidth") <= width
            # what is under the middle of it is the button itself
            x, y = stop["x"] + stop["width"] / 2, stop["y"] + stop["height"] / 2
            assert (
                visitor.page.evaluate("([x, y]) => document.elementFromPoint(x, y).className", [x, y])
                == "tw-stop"
            )


def test_the_link_in_figures_charts_and_a_table(console: Console, visit: Visit) -> None:
    visitor = visit()
    visitor.tab("link")
    visitor.see(".tw-chart svg path").first.wait_for(state="attached")
    assert visitor.see(".tw-chart svg").count() == 3
    visitor.see("summary:has-text('As a table')").click()
    row = visitor.see(".tw-table tbody tr").first
    row.wait_for()
    with visitor.driving("ArrowUp", lambda: _number(row.locator("td").nth(2).inner_text()) > 0):
        pass
    console.wait_for_rest("walter")
    sent = visitor.see(".tw-figures div:has(dt:text-is('Bytes sent')) dd")
    figures = console.view("walter")["figures"]
    wait_until(lambda: _number(sent.inner_text()) >= figures["bytes_sent"], "the figure to be shown")


def _number(text: str) -> float:
    return float(text.replace(",", "").replace("–", "0"))


def test_the_wheel_is_taken_asked_for_and_handed_over(console: Console, visit: Visit) -> None:
    one, other = visit(), visit(phone=True)
    for visitor, name in ((one, "Ada"), (other, "Bo")):
        visitor.button("Settings").click()
        visitor.page.get_by_label("Your name").fill(name)
        visitor.press(".tw-dialog .primary")
    wait_until(lambda: one.see(".tw-wheel .tw-hidden").inner_text() == "Looking on: 2", "both to be counted")
    one.button("Take the wheel").click()
    other.page.get_by_text("Ada drives").wait_for()
    other.button("Ask for the wheel").tap()
    dialog = one.page.get_by_role("alertdialog")
    dialog.get_by_text("Bo asks for the wheel.").wait_for()
    dialog.get_by_role("button", name="Keep").click()
    dialog.wait_for(state="detached")
    other.button("Ask for the wheel").tap()
    dialog.get_by_role("button", name="Hand over").click()
    other.page.get_by_text("You drive").wait_for()
    one.page.get_by_text("Bo drives").wait_for()
    other.button("Let go").tap()
    one.page.get_by_text("Nobody drives").wait_for()


def test_a_connection_that_is_lost_comes_back(console: Console, visit: Visit) -> None:
    visitor = visit(before=lambda visitor: visitor.page.add_init_script(SOCKETS))
    keyboard = visitor.page.keyboard
    visitor.drive(lambda: keyboard.down("w"), lambda: keyboard.up("w"), lambda: console.moves("walter"))
    visitor.page.evaluate("sockets.at(-1).close()")
    console.wait_for_rest("walter")
    visitor.see(".tw-connection.open").wait_for()
    assert visitor.page.evaluate("sockets.length") == 2
    assert visitor.see(".tw-hand-says").inner_text() == "The connection stalls: the robot was stopped."
    console.wait_for_rest("walter")  # the key is held still: nothing resumes by itself
    assert console.state("walter")["wheel"]["driver"] is None
    keyboard.up("w")
    with visitor.driving("w", lambda: console.moves("walter")):
        pass
