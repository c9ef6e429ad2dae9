"""Which robot a URL or a name means, and what is said of those that mean none."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire import configuration
from turtlewire.configuration import entries, protocol_of, target
from turtlewire.errors import DataError, TurtlewireError, UsageError
from turtlewire.links.faults import Faults
from turtlewire.robots import car, two_engine, walter

if TYPE_CHECKING:
    from collections.abc import Callable


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Write ``robots.toml``; its path."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    file = tmp_path / "turtlewire" / "robots.toml"

    def write(text: str) -> Path:
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, "utf-8")
        return file

    return write


@pytest.mark.parametrize(
    ("url", "port", "protocol", "overrides"),
    [
        ("/dev/ttyUSB0", "/dev/ttyUSB0", "walter", {}),
        ("COM3?protocol=frame", "COM3", "frame", {}),
        ("pty?protocol=simple", "pty", "simple", {}),
        ("/dev/ttyUSB0?protocol=simple&window=4", "/dev/ttyUSB0", "simple", {"window": 4}),
        ("serial:///dev/ttyUSB0?baud=115200", "serial:///dev/ttyUSB0", "walter", {"baud": 115200}),
        ("socket://host:1?protocol=walter&gentle=no", "socket://host:1", "walter", {"gentle": False}),
        ("/dev/x?groups=cq", "/dev/x", "walter", {"groups": frozenset("CQ")}),
        ("/dev/x?protocol=frame&repeat_s=never", "/dev/x", "frame", {"repeat_s": None}),
        ("/dev/x?protocol=frame&heartbeat_s=0.5", "/dev/x", "frame", {"heartbeat_s": 0.5}),
        ("/dev/x?protocol=simple&turn=arc&pen_light=YES", "/dev/x", "simple", {"turn": "arc", "pen_light": True}),
    ],
)  # fmt: skip
def test_urls(url: str, port: str, protocol: str, overrides: dict[str, Any]) -> None:
    found = target(url)
    assert (found.name, found.port, found.protocol, found.overrides) == (url, port, protocol, overrides)
    assert not found.is_simulated
    settings = found.settings()
    assert protocol_of(settings) == protocol
    for name, value in overrides.items():
        assert getattr(settings, name) == value


def test_the_url_says_more_than_the_settings_and_the_protocol_too() -> None:
    found = target("/dev/x?speed=7", "simple")
    settings = found.settings(car.Settings(speed=5, window=3))
    assert isinstance(settings, car.Settings)
    assert (settings.speed, settings.window) == (7, 3)
    with pytest.raises(UsageError, match=r"/dev/x.* speaks simple, but .* speaks walter"):
        found.settings(walter.Settings())
    with pytest.raises(UsageError, match="speaks frame"):
        found.settings(two_engine.Settings())
    nonsense: Any = 5
    with pytest.raises(UsageError, match="must be the Settings of a robot's driver, but are 5"):
        protocol_of(nonsense)


def test_faults_keep_their_plus() -> None:
    found = target("/dev/x?faults=lose:0.25,stall:5+2,seed:7")
    assert found.faults == Faults(lose=0.25, stalls=((5.0, 2.0),), seed=7)
    assert target("sim:frame?faults=split:1").faults == Faults(split=1)
    assert target("/dev/x").faults is None


def test_simulated_robots_keep_their_options_as_they_are() -> None:
    found = target("sim:simple?arena=my+maze%2B.toml&slip=0.1")
    assert found.is_simulated
    assert (found.port, found.protocol) == ("sim:simple", "simple")
    assert found.simulation == {"arena": "my maze+.toml", "slip": "0.1"}


def test_a_dialect_by_name_or_file(tmp_path: Path) -> None:
    settings = target("/dev/x?protocol=frame&dialect=0.1-literal").settings()
    assert isinstance(settings, two_engine.Settings)
    assert settings.dialect is not None
    assert settings.dialect.name == "0.1-literal"
    with pytest.raises(DataError, match=r"none.toml: No such file"):
        target(f"/dev/x?protocol=frame&dialect={tmp_path}/none.toml")


def test_calibrations(tmp_path: Path) -> None:
    file = tmp_path / "calibration.toml"
    file.write_text("settle_s = 0.5\n", "utf-8")
    for protocol in ("simple", "frame"):
        settings = target(f"/dev/x?protocol={protocol}&calibration={file}").settings()
        assert isinstance(settings, car.Settings | two_engine.Settings)
        assert settings.calibration.settle_s == 0.5


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("/dev/x?protocol=morse", "'/dev/x?protocol=morse': protocol is 'morse', but must be walter, simple or frame"),
        ("/dev/x?window=4", "unknown option 'window'; a serial port has baud.*speaks walter: baud, speed,"),
        ("/dev/x?protocol=simple&window=many", "window is 'many', but must be a whole number"),
        ("/dev/x?protocol=simple&turn=back", "turn is 'back', but must be spot or arc"),
        ("/dev/x?gentle=perhaps", "gentle is 'perhaps', but must be yes or no"),
        ("/dev/x?heartbeat_s=often", "heartbeat_s is 'often', but must be a number of seconds, or never"),
        ("/dev/x?speed=1&speed=2", "speed stands there twice"),
        ("/dev/x?faults=loose:1", "'/dev/x.faults=loose:1': faults 'loose:1'.*write NAME:VALUE"),
        ("sim:simple?faults=lose:2", "'lose:2' means nothing"),
        ("sim:simple?protocol=walter", "no simulated robot 'simple'"),
        ("sim:", "no simulated robot ''; there is sim:walter, sim:simple and sim:frame"),
        ("tty USB0", "is no port"),
        ("", "is no port"),
    ],
)  # fmt: skip
def test_urls_that_mean_nothing(url: str, said: str) -> None:
    with pytest.raises(UsageError, match=said.replace("?", ".")):
        target(url)


# ---------------------------------------------------------------- robots.toml


def test_named_robots(robots: Callable[[str], Path]) -> None:
    robots(
        '[elsie]\nport = "/dev/ttyUSB0"\nspeed = 60\ngentle = false\nreply_timeout_s = 1.5\n'
        '[herbie]\nport = "socket://h:1"\nprotocol = "simple"\nfaults = "stall:5+2"\n'
        '[dot-1]\nport = "sim:frame"\nprotocol = "frame"\nslip = 0.1\n'
    )
    elsie, herbie, dot = (target(name, "frame") for name in ("elsie", "herbie", "dot-1"))
    assert elsie[:3] == ("elsie", "/dev/ttyUSB0", "walter")
    assert elsie.overrides == {"speed": 60, "gentle": False, "reply_timeout_s": 1.5}
    assert herbie[:3] == ("herbie", "socket://h:1", "simple")
    assert herbie.faults == Faults(stalls=((5.0, 2.0),))
    assert dot[:3] == ("dot-1", "sim:frame", "frame")
    assert dot.simulation == {"slip": "0.1"}


def test_files_beside_it_are_found(robots: Callable[[str], Path]) -> None:
    file = robots('[a]\nport = "/dev/x"\nprotocol = "simple"\ncalibration = "a.toml"\n')
    (file.parent / "a.toml").write_text("wheelbase_mm = 99\n", "utf-8")
    settings = target("a").settings()
    assert isinstance(settings, car.Settings)
    assert settings.calibration.wheelbase_mm == 99.0


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ('[a]\nport = "/dev/x"\nspeed = 0\n', 1, "the setting speed is 0, but must be from 1 to 255"),
        ('\n\n[a]\nport = "/dev/x"\nwindow = 4\n', 3, "unknown option 'window'"),
        ('# [a\n[a]\nport = "/dev/x"\nspeed = "fast"\n', 2, "speed is 'fast', but must be a whole number"),
        (
            '[a]\nport = "/dev/x"\nspeed = [1]\n',
            1,
            "speed is [1], but must be a text, a number, true or false",
        ),
        ('[a]\nport = "/dev/x"\nprotocol = "morse"\n', 1, "must be walter, simple or frame"),
        ('[a]\nport = "/dev/x"\nfaults = "x"\n', 1, "faults 'x'"),
        ("[a]\n", 1, "port is '', but must be where the robot is"),
        ('[a]\nport = "/dev/x?speed=4"\n', 1, "has lines of its own"),
        ('[a]\nport = "a"\n', 1, "port is 'a'"),
        ('[a]\nport = "http://x"\n', 1, "there is no 'http' port"),
        ('[a]\nport = "sim:frame"\nprotocol = "walter"\n', 1, "there is no simulated robot 'frame'"),
        ("b.x = 1\na = 5\n", 2, "a robot is a table"),
    ],
)
def test_entries_that_are_wrong(robots: Callable[[str], Path], text: str, line: int, said: str) -> None:
    file = robots(text)
    with pytest.raises(DataError) as caught:
        target("a")
    assert str(caught.value).startswith(f"{file}, line {line}, [a]: ")
    assert str(caught.value).count(f"{file}, line") == 1
    assert said in str(caught.value)


@pytest.mark.parametrize("name", ["walter", "COM3", "pty", "1st", "a b", "Simple"])
def test_names_that_mean_something_else(robots: Callable[[str], Path], name: str) -> None:
    robots(f'["{name}"]\nport = "/dev/x"\n')
    with pytest.raises(DataError, match="a robot's name is a letter, then"):
        entries()[name].target()


def test_a_wrong_entry_is_no_harm_to_the_others(robots: Callable[[str], Path]) -> None:
    robots('[bad]\nport = 5\n[good]\nport = "/dev/x"\n')
    assert target("good").port == "/dev/x"
    with pytest.raises(DataError):
        target("bad")


def test_names_that_nobody_has(robots: Callable[[str], Path], tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"'elsie' is no port: .*robots.toml would have them, but does not"):
        target("elsie")
    robots("")
    with pytest.raises(UsageError, match=r"robots.toml has none"):
        target("elsie")
    robots('[dot]\nport = "x"\n[herbie]\nport = "x"\n')
    with pytest.raises(UsageError, match=r"robots.toml has dot, herbie"):
        target("elsie")


def test_files_that_are_none(robots: Callable[[str], Path]) -> None:
    file = robots("[elsie\n")
    with pytest.raises(DataError, match=rf"^{file}: .*line 1"):
        entries()
    file.write_bytes(b"[a]\nport = '\xff'\n")
    with pytest.raises(DataError, match=rf"^{file}, line 2: this is not UTF-8"):
        entries()
    file.unlink()
    assert entries() == {}
    file.mkdir()
    with pytest.raises(DataError, match=rf"^cannot read {file}: Is a directory"):
        entries()


def test_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", "/etc/here")
    assert configuration.path() == Path("/etc/here/turtlewire/robots.toml")
    for ignored in ("", "relative"):
        monkeypatch.setenv("XDG_CONFIG_HOME", ignored)
        assert configuration.path() == Path.home() / ".config" / "turtlewire" / "robots.toml"


@pytest.mark.parametrize("protocol", configuration.PROTOCOLS)
def test_every_setting_of_every_driver_can_be_written(protocol: str) -> None:
    settings = target("/dev/x", protocol).settings()
    assert set(configuration.SETTINGS[protocol]) == set(settings._fields)
    for name, kind in configuration.SETTINGS[protocol].items():
        assert kind.wanted
        if name != "groups":  # any letters may be some: the settings themselves refuse them
            with pytest.raises(TurtlewireError):
                configuration.read_setting(protocol, name, "?", "here")
