"""What flashes, and what is said about it. With a real board: tests/emulator/test_flash.py."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LinkError, UsageError
from turtlewire.firmware import BOARDS, flash
from turtlewire.firmware.flash import flash_command

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.firmware import Built

    from .conftest import ArduinoCli

PORT = "/dev/ttyTEST"


def test_by_avrdude(simple_car: Built) -> None:
    assert flash_command(simple_car, PORT) == [
        *("avrdude", "-p", "atmega328p", "-c", "arduino", "-P", PORT, "-b", "115200", "-D"),
        *("-U", f"flash:w:{simple_car.hex}:i"),
    ]
    mega = flash_command(simple_car._replace(board=BOARDS["mega"]), PORT)
    assert mega[1:5] == ["-p", "atmega2560", "-c", "wiring"]


def test_nothing_to_flash_with(simple_car: Built, no_tools: Path) -> None:
    with pytest.raises(UsageError, match=r"nothing to flash with: .*apt install .*avrdude"):
        flash_command(simple_car, PORT)


def test_by_arduino_cli(
    simple_car: Built, arduino_cli: ArduinoCli, capfd: pytest.CaptureFixture[str]
) -> None:
    arduino_cli.then("done", 0)
    flash(simple_car, PORT, None)
    assert arduino_cli.calls == [
        [
            *("upload", "--fqbn", "arduino:avr:uno", "--port", PORT, "--verbose", "--verify"),
            *("--input-file", str(simple_car.hex)),
        ]
    ]
    assert capfd.readouterr() == ("", "done\n")


@pytest.mark.parametrize(
    ("said", "failure", "state"),
    [
        (
            "avrdude: stk500_recv(): programmer is not responding",
            "no bootloader answers",
            "Nothing was written",
        ),
        ("avrdude: stk500v2_ReceiveMessage(): timeout communicating", "pins 0 and 1", "Nothing was written"),
        (
            "avrdude: Device signature = 0x1e9514\navrdude: Expected signature for ATmega328P is 1E 95 0F",
            "the chip there, 0x1e9514, is not the atmega328p of the uno",
            "Nothing was written",
        ),
        ("avrdude: writing flash (2758 bytes):\n", "see above", "holds a part of this program"),
        (
            (
                "avrdude: writing flash (2758 bytes):\navrdude: 2758 bytes of flash written\n"
                "avrdude: verification error; content mismatch"
            ),
            "its chip is worn",
            "came to no good end",
        ),
        ("no such board", "is it the right port", "Nothing was written"),
    ],
)
def test_what_went_wrong(
    simple_car: Built, arduino_cli: ArduinoCli, said: str, failure: str, state: str
) -> None:
    """By the words of avrdude 6.3 and 7.1."""
    arduino_cli.then(said, 1)
    with pytest.raises(LinkError, match=f"(?i){failure}") as caught:
        flash(simple_car, PORT, None)
    assert state in caught.value.__notes__[0]
    assert PORT in str(caught.value)
