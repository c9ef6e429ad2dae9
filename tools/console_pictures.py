"""Photographs the web console for the manual: ``python -m tools.console_pictures FOLDER``.

A real console with its simulated robots, and Debian's Chromium. The robot draws an example first.
"""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from playwright.sync_api import sync_playwright

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

DESKTOP: dict[str, Any] = {"viewport": {"width": 1280, "height": 800}}
PHONE: dict[str, Any] = {
    "viewport": {"width": 390, "height": 780},
    "device_scale_factor": 2,
    "has_touch": True,
    "is_mobile": True,
}
# Quick enough to wait for, and it has turns.
PROGRAM = """to star :side
  repeat 5 [fd :side rt 144]
end

repeat 6 [
  star 220
  rt 60
]
"""


def _open(browser: Browser, address: str, *, is_phone: bool, is_dark: bool) -> Page:
    context = browser.new_context(
        **(PHONE if is_phone else DESKTOP),
        locale="en-GB",
        color_scheme="dark" if is_dark else "light",
        reduced_motion="reduce",
    )
    page = context.new_page()
    page.goto(address)
    page.locator(".tw-figures dd").first.wait_for(state="attached")
    return page


def _draw(page: Page) -> None:
    """Have the robot draw, and look at it while it does."""
    page.locator("#tw-tab-program").click()
    page.locator(".cm-content").fill(PROGRAM)
    page.get_by_role("button", name="Run", exact=True).click()


def _take(page: Page, tab: str, file: Path) -> None:
    page.locator(f"#tw-tab-{tab}").click()
    page.get_by_role("button", name="Show all").click()
    page.wait_for_timeout(1500)  # until charts have grown, and what was said in passing has gone by
    page.screenshot(path=file)
    print(f"{file}: {file.stat().st_size / 1000:.0f} kB")


def main(folder: Path) -> None:
    with tempfile.TemporaryDirectory() as programs:
        console = subprocess.Popen(
            [sys.executable, "-m", "turtlewire", "console", "--listen-port", "0", "--programs", programs],
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        try:
            assert console.stdout is not None
            found = None
            while found is None:
                found = re.search(r"turtlewire console: (\S+)", console.stdout.readline())
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(
                    executable_path="/usr/bin/chromium", args=["--no-sandbox", "--disable-gpu"]
                )
                desktop = _open(browser, found[1], is_phone=False, is_dark=False)
                dark = _open(browser, found[1], is_phone=False, is_dark=True)
                phone = _open(browser, found[1], is_phone=True, is_dark=False)
                night = _open(browser, found[1], is_phone=True, is_dark=True)
                _draw(desktop)
                desktop.wait_for_timeout(25_000)
                _take(desktop, "program", folder / "console-program.png")
                _take(night, "program", folder / "console-phone-program.png")
                _take(dark, "traffic", folder / "console-traffic.png")
                desktop.wait_for_timeout(20_000)
                _take(desktop, "drive", folder / "console-drive.png")
                _take(phone, "drive", folder / "console-phone.png")
                _take(dark, "link", folder / "console-link.png")
                browser.close()
        finally:
            console.send_signal(signal.SIGINT)
            console.wait()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
