"""Writing robots.toml: what people wrote stays."""

from __future__ import annotations

import stat
from typing import TYPE_CHECKING

import pytest

from turtlewire import robots_file
from turtlewire.configuration import target
from turtlewire.errors import DataError, OutputError, UsageError
from turtlewire.robots import two_engine
from turtlewire.robots.calibration import CarCalibration, TwoEngineCalibration, lines, made

if TYPE_CHECKING:
    from pathlib import Path

WRITTEN = """\
# The robots of our class.

[elsie]   # the old one
port = "/dev/ttyUSB0"
speed = 60      # not so fast

[herbie]
port = "socket://herbie.local:2000"
protocol = "simple"
calibration = "herbie.toml"
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    return tmp_path / "turtlewire" / "robots.toml"


@pytest.fixture
def written(file: Path) -> Path:
    file.parent.mkdir()
    file.write_text(WRITTEN, "utf-8")
    (file.parent / "herbie.toml").write_text("trim_deg = 1.5  # bent\n", "utf-8")
    return file


def test_a_first_robot_makes_the_file(file: Path) -> None:
    assert robots_file.write("dot", {"port": "sim:frame", "slip": 0.01}) == [file]
    assert file.read_text("utf-8") == '[dot]\nport = "sim:frame"\nslip = 0.01\n'


def test_everything_else_stays_as_people_wrote_it(written: Path) -> None:
    written.chmod(0o640)
    robots_file.write("elsie", {"mm_per_s_per_unit": 1.25, "speed": 80})
    assert written.read_text("utf-8") == WRITTEN.replace(
        "speed = 60      # not so fast\n", "speed = 80      # not so fast\nmm_per_s_per_unit = 1.25\n"
    )
    assert stat.S_IMODE(written.stat().st_mode) == 0o640
    robots_file.write("elsie", {"mm_per_s_per_unit": None, "speed": 60})
    assert written.read_text("utf-8") == WRITTEN


ABOUT_THE_NEXT = """\
[elsie]
port = "sim:walter"
# she is old

# this one is new:
[herbie]
port = "sim:simple"

# it was bent
[herbie.calibration]
trim_deg = 1.0

# the end
"""


def test_comments_stay_with_what_they_are_about(file: Path) -> None:
    file.parent.mkdir()
    file.write_text(ABOUT_THE_NEXT, "utf-8")
    robots_file.write("elsie", {"speed": 60, "calibration": {"turn_scale": 1.01}})
    robots_file.write("herbie", {"window": 2, "calibration": {"forward": {"dead_pwm": 30}}})
    assert file.read_text("utf-8") == ABOUT_THE_NEXT.replace(
        "# she is old\n", "# she is old\nspeed = 60\n\n[elsie.calibration]\nturn_scale = 1.01\n"
    ).replace('port = "sim:simple"\n', 'port = "sim:simple"\nwindow = 2\n').replace(
        "trim_deg = 1.0\n", "trim_deg = 1.0\n\n[herbie.calibration.forward]\ndead_pwm = 30\n"
    )


def test_tables_in_any_order(file: Path) -> None:
    file.parent.mkdir()
    text = '[herbie]\nport = "sim:simple"\n[dot]\nport = "sim:frame"\n[herbie.calibration]\ntrim_deg = 1.0\n'
    file.write_text(text, "utf-8")
    robots_file.write("herbie", {"calibration": {"trim_deg": 2.0}})
    assert file.read_text("utf-8") == text.replace("1.0", "2.0")


def test_a_robot_more_comes_last(written: Path) -> None:
    robots_file.write("dot", {"port": "sim:frame"})
    assert written.read_text("utf-8") == WRITTEN + '\n[dot]\nport = "sim:frame"\n'
    assert target("dot").port == "sim:frame"


def test_a_calibration_stands_with_its_robot(file: Path) -> None:
    curve = {"dead_pwm": 38, "table": [[60, 35.0], [255, 330.0]]}
    robots_file.write("dot", {"port": "sim:frame", "calibration": {"track_mm": 150.0, "left": curve}})
    text = file.read_text("utf-8")
    assert "[dot.calibration]\ntrack_mm = 150.0\n" in text
    assert "[dot.calibration.left]\ndead_pwm = 38\n" in text
    settings = target("dot").settings()
    assert isinstance(settings, two_engine.Settings)
    assert settings.calibration.track_mm == 150.0
    assert settings.calibration.left.table == ((60, 35.0), (255, 330.0))
    # Lines of it change one by one, and go.
    robots_file.write("dot", {"calibration": {"left": {"table": None, "mm_per_s_per_pwm": 1.5}}})
    settings = target("dot").settings()
    assert isinstance(settings, two_engine.Settings)
    assert settings.calibration.track_mm == 150.0
    assert (settings.calibration.left.dead_pwm, settings.calibration.left.table) == (38, ())


def test_a_calibration_in_a_file_of_its_own_stays_there(written: Path) -> None:
    own = written.parent / "herbie.toml"
    assert robots_file.write("herbie", {"calibration": {"trim_deg": 2.0, "forward": {"dead_pwm": 50}}}) == [
        own
    ]
    assert own.read_text("utf-8") == "trim_deg = 2.0  # bent\n\n[forward]\ndead_pwm = 50\n"
    assert written.read_text("utf-8") == WRITTEN
    with pytest.raises(DataError, match=r"herbie\.toml: CarCalibration: trim_deg is 50"):
        robots_file.write("herbie", {"calibration": {"trim_deg": 50.0}})
    assert "trim_deg = 2.0" in own.read_text("utf-8")


@pytest.mark.parametrize(
    ("name", "values", "error", "says"),
    [
        ("frame", {"port": "sim:frame"}, UsageError, "'frame' cannot be the name of a robot"),
        ("dot", {"protocol": "frame"}, DataError, "port is ''"),
        ("elsie", {"speed": 0}, DataError, "speed is 0"),
        (
            "elsie",
            {"calibration": {"track_mm": 150.0}},
            DataError,
            "unknown field `track_mm`",
        ),
        ("elsie", {"calibration": {"turn_scale": 0.01}}, DataError, "turn_scale is 0.01"),
        ("dot", {"port": "sim:frame", "calibration": {"track": 1.0}}, DataError, "unknown field `track`"),
    ],
)
def test_nothing_is_written_unless_the_robot_can_be_used_then(
    written: Path, name: str, values: dict[str, object], error: type[Exception], says: str
) -> None:
    with pytest.raises(error, match=says):
        robots_file.write(name, values)
    assert written.read_text("utf-8") == WRITTEN


@pytest.mark.parametrize("text", ["elsie = 1\n", "[elsie\n", "# \xff\n"])
def test_a_file_that_cannot_be_understood_is_left_alone(written: Path, text: str) -> None:
    written.write_bytes(text.encode("latin-1"))
    with pytest.raises(DataError, match=r"robots\.toml"):
        robots_file.write("elsie", {"port": "/dev/ttyUSB0"})
    assert written.read_bytes() == text.encode("latin-1")


def test_a_file_that_cannot_be_written(file: Path) -> None:
    file.parent.write_text("no folder", "utf-8")
    with pytest.raises((OutputError, DataError), match=r"cannot (write|read) .*robots\.toml"):
        robots_file.write("dot", {"port": "sim:frame"})


def test_a_url_is_lines_of_a_table() -> None:
    url = "/dev/ttyUSB0?protocol=simple&window=4&tolerance_mm=0.5&faults=stall:5+2&turn=007"
    assert robots_file.options(url) == {
        "port": "/dev/ttyUSB0",
        "protocol": "simple",
        "window": 4,
        "tolerance_mm": 0.5,
        "faults": "stall:5+2",
        "turn": "007",
    }
    assert robots_file.options("sim:walter") == {"port": "sim:walter"}


def test_lines_mean_the_calibration_they_were_made_of() -> None:
    for calibration in (
        CarCalibration(steering=((-255, -200.0), (255, 210.0))),
        TwoEngineCalibration(pen_servo=None, left_backward=TwoEngineCalibration().left, track_mm=3.0),
    ):
        table = {key: value for key, value in lines(calibration).items() if value is not None}
        table["settle_s"] = 0.05
        for key, value in table.items():
            if isinstance(value, dict):
                table[key] = {k: v for k, v in value.items() if v is not None}
        assert made(type(calibration), table) == calibration
