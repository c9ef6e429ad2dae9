"""``turtlewire ports``: what the operating system knows of serial ports."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
import serialx

from turtlewire.cli.main import main

if TYPE_CHECKING:
    from pathlib import Path


def info(device: str, resolved: str, **known: object) -> serialx.SerialPortInfo:
    """A port as the operating system describes it."""
    port = serialx.SerialPortInfo(device, resolved, None, None, None, None, None, None, None, None)
    for name, value in known.items():
        setattr(port, name, value)
    return port


UNO = info(
    "/dev/serial/by-id/usb-uno",
    "/dev/ttyACM0",
    vid=0x2341,
    pid=0x43,
    serial_number="85",
    manufacturer="Arduino",
    product="Uno",
)
PLAIN = info("/dev/ttyS0", "/dev/ttyS0")


@pytest.fixture(autouse=True)
def configured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (tmp_path / "turtlewire").mkdir()
    (tmp_path / "turtlewire" / "robots.toml").write_text(
        'stray = 5\n[elsie]\nport = "/dev/ttyACM0"\n[dot]\nport = "serial:///dev/ttyACM0"\n[x]\nport = 5\n',
        "utf-8",
    )


def test_the_list(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(serialx, "list_serial_ports", lambda: [PLAIN, UNO])
    assert main(["ports"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "/dev/serial/by-id/usb-uno Arduino Uno; USB 2341:0043; serial number 85; is /dev/ttyACM0; robot: elsie, dot",
        "/dev/ttyS0       nothing is known of it",
    ]


def test_for_programs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(serialx, "list_serial_ports", lambda: [UNO])
    assert main(["ports", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [
        {
            "port": "/dev/serial/by-id/usb-uno",
            "device": "/dev/ttyACM0",
            "manufacturer": "Arduino",
            "product": "Uno",
            "serial_number": "85",
            "vendor_id": "2341",
            "product_id": "0043",
            "robots": ["elsie", "dot"],
        }
    ]


def test_none(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(serialx, "list_serial_ports", list)
    assert main(["ports"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert "there is no serial port: is the robot plugged in" in err
    assert main(["ports", "--json"]) == 0
    assert capsys.readouterr().out == "[]\n"


def test_a_system_that_will_not_tell(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse() -> list[serialx.SerialPortInfo]:
        raise PermissionError("not for you")

    monkeypatch.setattr(serialx, "list_serial_ports", refuse)
    assert main(["ports"]) == 3
    assert capsys.readouterr().err == "turtlewire: cannot list the serial ports: not for you\n"


def test_the_real_ones_can_be_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ports", "--json"]) == 0
    assert isinstance(json.loads(capsys.readouterr().out), list)
