"""Dialects: what is made of a file, and what is said about a wrong one, with its line."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from tools.generators import frame as generator
from turtlewire.errors import DataError, MessageError
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.description import DialectError
from turtlewire.protocols.frame.dialect import FROM_ROBOT, SHIPPED, TO_ROBOT, load, read_dialect, shipped
from turtlewire.protocols.frame.lines import line_of, lines
from turtlewire.protocols.frame.messages import (
    MESSAGES,
    EngineBackward,
    EngineDirectionUnknown,
    EngineForward,
    SetServoPosition,
)
from turtlewire.protocols.frame.page import page

ROOT = Path(__file__).parents[4]

GOOD = """\
protocol = "frame"
dialect = "mine"
[crc]
algorithm = "CRC-8/ROHC"
coverage = "seq"
[counts]
wheels = 4
[enumerations]
gear = { slow = 1, fast = 300 }
[[message]]
name = "SetWheel"
type = 0x20
direction = "to robot"
channel = "wheel"
stop = { speed = 0, brake = true }
fields = [
  { name = "wheel", kind = "u8", below = "wheels" },
  { name = "speed", kind = "i16", min = -500, max = 500, unit = "mm/s" },
  { name = "brake", kind = "bool" },
]
[[message]]
name = "Gear"
type = 0x21
direction = "both"
fields = [{ name = "gear", kind = "u16", enumeration = "gear" }]
[[message]]
name = "Level"
type = 0x20
direction = "from robot"
fields = [{ name = "level", kind = "f32", min = 0, max = 1.5 }]
[[message]]
name = "Other"
type = 0x20
direction = "from robot"
fields = [{ name = "level", kind = "f32", min = 0, max = 1.5 }]
[[ambiguous]]
name = "LevelOrOther"
messages = ["Level", "Other"]
"""


def test_a_dialect_of_ones_own() -> None:
    dialect = read_dialect(GOOD)
    assert (dialect.name, dialect.title, dialect.baud) == ("mine", "mine", 115200)
    assert str(dialect.checksum) == "CRC-8/ROHC from seq"
    assert dialect.counts == {"wheels": 4}
    wheel = dialect["SetWheel"]
    assert wheel is dialect["set_wheel"]
    assert str(wheel(3, -500, True)) == "set_wheel wheel=3 speed=-500 brake=1"  # noqa: FBT003
    assert [str(message) for message in dialect.stop_messages()] == [
        f"set_wheel wheel={n} speed=0 brake=1" for n in range(4)
    ]
    gear = dialect.enumerations["gear"]
    assert gear.__name__ == "Gear"
    assert str(dialect["Gear"](gear["fast"])) == "gear gear=fast"
    assert dialect.pack(dialect["Gear"](gear["fast"]), FROM_ROBOT) == b"\x21\x01\x2c"
    assert dialect.parse("gear gear=FAST") == dialect["Gear"](300)
    assert dialect.parse("set_wheel wheel=0 speed=-1 brake=true").values() == (0, -1, 1)
    assert [entry.goes(TO_ROBOT) for entry in dialect.entries] == [True, True, False, False, False]
    assert repr(dialect) == "<Dialect mine: SetWheel, Gear, Level, Other, LevelOrOther>"


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("set_wheel wheel=4 speed=0 brake=0", "wheel is 4, but this robot has 4 wheels"),
        ("set_wheel wheel=0 speed=501 brake=0", "speed is 501, but must be a whole number from -500 to 500"),
        ("set_wheel wheel=0 speed=0 brake=2", "brake is 2, but must be a whole number from 0 to 1"),
        ("set_wheel wheel=0 speed=0 brake=yes", "'yes' is not a whole number and none of false, true"),
        ("gear 2", "gear is 2, but must be one of slow .1., fast .300."),
        ("gear quick", "'quick' is not a whole number and none of slow, fast"),
        ("level 1.6", "level is 1.6.*, but must be a number from 0 to 1.5"),
        ("level nan", "level is nan, but must be a number"),
        ("level 1e40", "level is 1e.40, but must be a number"),
        ("level high", "'high' is not a number"),
        ("level_or_other 1", "level_or_other cannot be sent: it is what a decoder reports"),
    ],
)
def test_what_a_message_may_not_carry(text: str, error: str) -> None:
    with pytest.raises(MessageError, match=error):
        read_dialect(GOOD).parse(text)


def test_a_message_of_another_dialect_or_direction() -> None:
    dialect = read_dialect(GOOD)
    with pytest.raises(MessageError, match="engine_forward is no message of the dialect mine"):
        dialect.check(EngineForward(0, 0))
    with pytest.raises(MessageError, match="level goes from robot, not to robot"):
        dialect.pack(dialect["Level"](1), TO_ROBOT)
    with pytest.raises(MessageError, match="mine has no message 'Fly'; it has set_wheel, gear"):
        dialect["Fly"]
    with pytest.raises(MessageError, match="level is '1', but must be"):
        dialect.check(dialect["Level"]("1"))


RANGE = "min = 0, max = 1.5 }]\n[[m"
AMBIGUOUS = '[[ambiguous]]\nname = "LevelOrOther"\nmessages = ["Level", "Other"]\n'
# What is changed in the good file, the line where the error is, and what it says.
WRONG = [
    ('"frame"', '"walter"', 1, "this describes a dialect of frame, not of 'walter'"),
    ('protocol = "frame"', "", 1, "'protocol' is missing"),
    ('"mine"', "7", 2, "dialect must be text, not 7"),
    ('"mine"', '"mine', 2, "not TOML: Illegal character"),
    ("[crc]", "speed = 1\n[crc]", 3, "there is no 'speed' here; known are protocol"),
    ("[crc]", "baud = 0\n[crc]", 3, "baud must be a whole number from 1 to 100000000, not 0"),
    ("CRC-8/ROHC", "CRC-9", 4, "there is no CRC 'CRC-9'; known are CRC-8/AUTOSAR"),
    ('coverage = "seq"', 'coverage = "all"', 5, "coverage must be one of magic, seq, size, payload, not 'all'"),
    ('coverage = "seq"', "polynom = 7", 5, "there is no 'polynom' here; known are algorithm, coverage"),
    ("[counts]\nwheels = 4", "[other]", 6, "there is no 'other' here"),
    ("wheels = 4", "wheels = 257", 7, "a count must be a whole number from 0 to 256, not 257"),
    ("wheels = 4", "wheels = true", 7, "a count must be a whole number"),
    ("wheels = 4", "Wheels = 4", 7, "'Wheels' is no name for this; one looks like engines"),
    ("{ slow = 1, fast = 300 }", "3", 9, "an enumeration looks like gear = "),
    ("{ slow = 1, fast = 300 }", "{}", 9, "an enumeration looks like gear = "),
    ("fast = 300", "fast = 1", 9, "fast has the number of slow: 1"),
    ("fast = 300", "fast = 4294967296", 9, "fast must be a whole number from -2147483648 to 4294967295"),
    ("fast = 300", "class = 3", 9, "'class' is a word that Python, C\\+\\+ or turtlewire keeps for itself"),
    ("fast = 300", "fast = 65536", 25, "fast of gear is 65536: too much for u16"),
    ('"SetWheel"', '"set wheel"', 11, "'set wheel' is no name for this; one looks like SetLamp"),
    ('name = "SetWheel"', "", 10, "'name' is missing"),
    ("type = 0x21", "type = 256", 23, "type must be a whole number from 0 to 255, not 256"),
    ("type = 0x21", "type = 1.5", 23, "type must be a whole number, not 1.5"),
    ("type = 0x21", "type = 0x20", 23, "Gear has the type of SetWheel, 20, to robot: nobody could tell"),
    ('direction = "both"', 'direction = "up"', 24, "direction must be one of to robot, from robot, both"),
    ('direction = "both"', 'direction = "both"\nkind = 1', 25, "there is no 'kind' here; known are name, type"),
    ('channel = "wheel"', 'channel = "Wheel"', 14, "'Wheel' is no name for this"),
    ('type = 0x20\ndirection = "from', 'type = 0x20\nchannel = "x"\ndirection = "from', 29, "only messages to the"),
    ('type = 0x20\ndirection = "from', 'type = 0x20\nstop = {}\ndirection = "from', 29, "only messages to"),
    ("stop = { speed = 0, brake = true }", "stop = 0", 15, "stop looks like { speed = 0 }"),
    ("stop = { speed = 0, brake = true }", "stop = { speed = 0 }", 15, "stop lacks brake"),
    ("stop = { speed = 0,", "stop = { wheel = 0, speed = 0,", 15, "'wheel' is no field that stop can set"),
    ("speed = 0, brake", "speed = 501, brake", 15, "speed must be a whole number from -500 to 500 .mm/s., not 501"),
    ("speed = 0, brake", "speed = true, brake", 15, "speed must be a whole number .*, not True"),
    ('{ name = "brake", kind = "bool" }', "7", 19, "a field looks like"),
    ('{ name = "brake", kind = "bool" }', '{ name = "brake" }', 19, "'kind' is missing"),
    ('name = "brake"', 'name = "Brake"', 19, "'Brake' is no name for this"),
    ('name = "brake"', 'name = "values"', 19, "'values' is a word that"),
    ('name = "brake"', 'name = "lambda"', 19, "'lambda' is a word that"),
    ('name = "brake"', 'name = "speed"', 19, "SetWheel has two fields 'speed'"),
    ('kind = "bool"', 'kind = "u64"', 19, "kind must be one of u8, bool, u16, i16, u32, i32, f32, not 'u64'"),
    ('kind = "bool"', 'kind = "bit"', 19, "kind must be one of"),
    ('kind = "bool"', 'kind = "bool", max = 1', 19, "a bool is 0 or 1: it has no other range"),
    ('kind = "bool"', 'kind = "bool", scale = 1', 19, "there is no 'scale' here; known are name, kind, unit"),
    ('kind = "bool"', 'kind = "u8", below = "wheels"', 19, "SetWheel has two fields with 'below'"),
    ("min = -500, max = 500", "min = -500, max = 32768", 18, "max must be a whole number from -32768 to 32767"),
    ("min = -500, max = 500", "min = -500.5", 18, "min must be a whole number"),
    ("min = -500, max = 500", "min = 6, max = 5", 18, "min 6 is above max 5"),
    ('below = "wheels"', 'below = "arms"', 17, "there is no 'arms' in \\[counts\\]"),
    ('below = "wheels"', 'below = "wheels", max = 3', 17, "max and below exclude one another"),
    ('enumeration = "gear"', 'enumeration = "tone"', 25, "there is no 'tone' in \\[enumerations\\]"),
    ('enumeration = "gear"', 'enumeration = "gear", min = 1', 25, "min and enumeration exclude one another"),
    (RANGE, 'min = nan }]\n[[m', 30, "min must be a number that an"),
    (RANGE, 'max = 4e38 }]\n[[m', 30, "max must be a number that an"),
    (RANGE, 'min = true }]\n[[m', 30, "min must be a number that an"),
    (RANGE, 'min = 2, max = 1.5 }]\n[[m', 30, "min 2 is above max 1.5"),
    (RANGE, 'below = "wheels" }]\n[[m', 30, "an f32 has no 'below'"),
    ('name = "Other"', 'name = "Level"', 32, "Level and Level have the same name in text: level"),
    ('"LevelOrOther"', '"Gear"', 37, "Gear and Gear have the same name in text: gear"),
    ('["Level", "Other"]', '["Level", "Nothing"]', 38, "there is no message 'Nothing'"),
    ('["Level", "Other"]', '["Level"]', 38, "these are not several messages of one type and direction"),
    ('["Level", "Other"]', '["Level", "Gear"]', 38, "these are not several messages of one type and direction"),
    ('["Level", "Other"]', '"Level"', 38, "messages must be a list, not 'Level'"),
    ('messages = ["Level", "Other"]', "", 36, "'messages' is missing"),
    ('messages = ["Level", "Other"]', "type = 3", 38, "there is no 'type' here; known are name, messages, doc"),
    ('max = 1.5 }]\n[[amb', 'max = 2 }]\n[[amb', 38, "messages of one type must have the same"),
    (AMBIGUOUS, "", 33, "Other has the type of Level, 20, from robot"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "what"), WRONG)
def test_every_error_names_the_line(old: str, new: str, line: int, what: str) -> None:
    assert old in GOOD
    with pytest.raises(DialectError, match=what) as caught:
        read_dialect(GOOD.replace(old, new, 1), "mine.toml")
    assert (caught.value.file, caught.value.line) == ("mine.toml", line)
    assert str(caught.value).startswith(f"mine.toml, line {line}: ")


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("", 1, "'protocol' is missing"),
        ('protocol = "frame"\ndialect = "x"\n', 1, "a dialect needs at least one"),
        ('protocol = "frame"\ndialect = "x"\nmessage = [3]\n', 3, "a message is a table"),
        ('protocol = "frame"\ndialect = "x"\nmessage = {}\n', 3, "message must be a list"),
        ('protocol = "frame"\ndialect = "x\n', 2, "not TOML"),
        ('protocol = "frame"\ndialect = """x\n', 3, "not TOML"),
        ("counts = 4\n" + GOOD.replace("[counts]", "[x]"), 7, "there is no 'x' here"),
    ],
)
def test_files_that_are_hardly_a_dialect(text: str, line: int, what: str) -> None:
    with pytest.raises(DialectError, match=what) as caught:
        read_dialect(text)
    assert caught.value.line == line


def test_what_is_ambiguous_is_a_table() -> None:
    told_apart = GOOD.replace(AMBIGUOUS, "").replace('"Other"\ntype = 0x20', '"Other"\ntype = 2')
    with pytest.raises(DialectError, match="line 1: what is ambiguous is a table"):
        read_dialect("ambiguous = [3]\n" + told_apart)


def test_a_message_fits_a_frame() -> None:
    def made(count: int) -> str:
        fields = ",\n".join(f'{{ name = "f{n}", kind = "u32" }}' for n in range(count))
        return (
            'protocol = "frame"\ndialect = "x"\n[[message]]\nname = "Big"\ntype = 1\n'
            f'direction = "to robot"\nfields = [\n{fields},\n{{ name = "a", kind = "u8" }},'
            '{ name = "b", kind = "u16" }]\n'
        )

    dialect = read_dialect(made(30))
    assert dialect.entries[0].layout.size == 124
    with pytest.raises(DialectError, match="line 38: with this field Big has 125 bytes; a frame carries 124"):
        read_dialect(made(31))


# --------------------------------------------------------------------------------------------------- settings


def test_settings_of_a_robot() -> None:
    plain = shipped("0.1")
    robot = plain.configured(
        counts={"engines": 4}, types={"EngineBackward": 7}, crc="rohc", coverage="size", baud=9600
    )
    assert robot.counts == {"servos": 2, "engines": 4}
    assert (str(robot.checksum), robot.baud) == ("CRC-8/ROHC from size", 9600)
    assert robot["EngineBackward"] is plain["EngineBackward"] is EngineBackward
    assert robot.pack(EngineBackward(3, 1), TO_ROBOT) == b"\x07\x03\x01"
    assert (plain.counts["engines"], str(plain.checksum), plain.baud) == (2, "CRC-8/SMBUS from magic", 115200)
    with pytest.raises(MessageError, match="engine_id is 3, but this robot has 2 engines"):
        plain.check(EngineForward(3, 1))
    again = robot.configured(counts={"servos": 0})
    assert (again.counts, again.baud) == ({"servos": 0, "engines": 4}, 9600)
    with pytest.raises(MessageError, match="servo_id is 0, but this robot has 0 servos"):
        again.check(SetServoPosition(0, 0))
    assert plain.configured(counts={"engines": 256}).check(EngineForward(255, 1))


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        ({"counts": {"arms": 1}}, "0.1 counts no 'arms'; it counts servos, engines"),
        ({"counts": {"engines": 257}}, "engines must be from 0 to 256, not 257"),
        ({"counts": {"engines": -1}}, "engines must be from 0 to 256, not -1"),
        ({"types": {"Fly": 1}}, "0.1 has no message 'Fly'"),
        ({"types": {"EngineBackward": 256}}, "the type of EngineBackward must be from 0 to 255, not 256"),
        (
            {"types": {"EngineBackward": 1}},
            "EngineForward and EngineBackward would have type 01 and 01.*0.1-literal",
        ),
        ({"crc": "CRC-16"}, "there is no CRC 'CRC-16'"),
        ({"coverage": "all"}, "coverage must be magic, seq, size, payload, not 'all'"),
    ],
)
def test_settings_that_mean_nothing(settings: dict[str, Any], error: str) -> None:
    with pytest.raises(DataError, match=error):
        shipped("0.1").configured(**settings)


def test_what_is_ambiguous_stays_so() -> None:
    with pytest.raises(
        DataError, match=r"would have type 01 and 02: the dialect 0.1-literal has them the same"
    ):
        shipped("0.1-literal").configured(types={"EngineBackward": 2})
    both = shipped("0.1-literal").configured(types={"EngineForward": 9, "EngineBackward": 9})
    assert [entry.type for entry in both.entries] == [0, 9, 9, 9]
    text = 'protocol = "frame"\ndialect = "x"\n[[message]]\nname = "A"\ntype = 1\ndirection = "both"\n'
    with pytest.raises(DataError, match="x counts no 'x'; it counts nothing"):
        read_dialect(text).configured(counts={"x": 1})


# ------------------------------------------------------------------------------------------- what ships, and files


def test_the_shipped_dialects_are_the_descriptions() -> None:
    folder = ROOT / "src/turtlewire/protocols/frame/dialects"
    assert sorted(path.stem for path in folder.iterdir()) == sorted(SHIPPED)
    assert tuple(generator.SOURCES) == SHIPPED
    for name, source in generator.SOURCES.items():
        spec = ROOT / "spec/protocols" / source
        assert (folder / f"{name}.toml").read_text("utf-8") == spec.read_text("utf-8")
        dialect = shipped(name)
        assert dialect.name == name == tomllib.loads(spec.read_text("utf-8"))["dialect"]
        assert shipped(name) is dialect
        assert {t.__name__ for t in dialect.types} == {t.__name__ for t in load(spec).types}
    with pytest.raises(DataError, match=r"there is no dialect '0\.2'; known are 0.1, 0.1-literal, telemetry"):
        shipped("0.2")


def test_the_typed_classes_are_what_the_descriptions_say() -> None:
    seen = set()
    for name in generator.TYPED:
        fresh = load(ROOT / "spec/protocols" / generator.SOURCES[name])
        for mine, typed in zip(fresh.types, shipped(name).types, strict=True):
            seen.add(typed)
            assert typed in MESSAGES
            assert (mine.__name__, mine.FIELDS, mine.__doc__) == (typed.__name__, typed.FIELDS, typed.__doc__)
            assert mine.__struct_fields__ == typed.__struct_fields__
    assert seen == set(MESSAGES)


def test_the_literal_dialect_knows_no_direction() -> None:
    literal = shipped("0.1-literal")
    for message in (EngineForward(1, 9), EngineBackward(1, 9)):
        assert FrameEncoder(literal).pack(message) == b"\x01\x01\x09"
    with pytest.raises(MessageError, match="engine_direction_unknown cannot be sent"):
        FrameEncoder(literal).pack(EngineDirectionUnknown(1, 9))
    assert literal.stop_messages() == [EngineForward(0, 0), EngineForward(1, 0)]


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="No such file"):
        load(tmp_path / "nothing.toml")
    wrong = tmp_path / "latin.toml"
    wrong.write_bytes(b'protocol = "frame"\n# \xe4\n')
    with pytest.raises(DialectError, match=r"latin.toml, line 2: this is not UTF-8"):
        load(wrong)
    windows = tmp_path / "windows.toml"
    windows.write_bytes(GOOD.replace("\n", "\r\n").replace('"LevelOrOther"', '"x"').encode())
    with pytest.raises(DialectError, match=r"windows.toml, line 37: 'x' is no name"):
        load(windows)


def test_the_page_of_a_dialect() -> None:
    text = page(read_dialect(GOOD.replace("[crc]", 'title = "A | B"\n[crc]')))
    assert text.startswith(
        "# A | B\n\nDialect `mine`: 115200 baud 8N1, CRC-8/ROHC from the seq on; 4 wheels.\n"
    )
    assert (
        "| 20 | `SetWheel` | `wheel` u8: 0.. below the number of wheels; `speed` i16: -500..500 (mm/s); "
        in text
    )
    assert "`gear` u16: 1 = slow, 300 = fast | 3 |" in text
    assert "`level` f32: 0..1.5 | 5 | Only reported, never sent. |" in text
    assert text.count("`Gear`") == 2
    lonely = page(shipped("0.1"), level=2)
    assert "### Host to robot: 0.1" in lonely
    assert "Robot to host" not in lonely


# ------------------------------------------------------------------------------------------------------- lines


TRICKY = '''\
# [not] a table
a = "# no comment [" # but this
b.c . "d" = 1
[t] # x
s = """
k = 1
\\""" still ""\"""
u = \'\'\'
k = 2
\'\'\'
list = [ 1, # one
  [2,
   3], { p = "}", q = [
  4 ] },
]
[x.y]
v = true
[[x.z]]
w = 1979-05-27T07:32:00
[[x.z]]
w = 2
[x.z.deep]
e = \'a"b\'
'''


def test_where_keys_stand() -> None:
    tomllib.loads(TRICKY)
    found = lines(TRICKY)
    assert {path: line for path, line in found.items() if path[:1] != ("x",)} == {
        (): 1,
        ("a",): 2,
        ("b",): 3,
        ("b", "c"): 3,
        ("b", "c", "d"): 3,
        ("t",): 4,
        ("t", "s"): 5,
        ("t", "u"): 8,
        ("t", "list"): 11,
        ("t", "list", 0): 11,
        ("t", "list", 1): 12,
        ("t", "list", 1, 0): 12,
        ("t", "list", 1, 1): 13,
        ("t", "list", 2): 13,
        ("t", "list", 2, "p"): 13,
        ("t", "list", 2, "q"): 13,
        ("t", "list", 2, "q", 0): 14,
    }
    assert found["x", "z", 0, "w"] == 19
    assert found["x", "z", 1, "w"] == 21
    assert found["x", "z", 1, "deep", "e"] == 23
    assert found["x", "y", "v"] == 17
    assert line_of(found, ("x", "z", 1, "nothing", 3)) == 20
    assert line_of(found, ("nowhere",)) == 1
