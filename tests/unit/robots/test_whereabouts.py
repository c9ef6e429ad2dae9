"""The account of where a robot is (decisions W11, W15)."""

from __future__ import annotations

import pytest

from turtlewire.protocols.walter import messages as m
from turtlewire.robots.walter.whereabouts import ANY_HEADING, Target, Whereabouts, matches
from turtlewire.turtle import HOME, Pose

A, B, C = Pose(0.0, 10.0, 0.0), Pose(0.0, 10.0, 90.0), Pose(20.0, 10.0, 90.0)


def account(*targets: Pose) -> Whereabouts:
    where = Whereabouts()
    for pose in targets:
        where.done(Target(pose, pen_down=True))
        where.position.robot = pose
    return where


def test_what_is_done_is_where_the_robot_was() -> None:
    where = account(A, B, C)
    where.done(None)  # no motion
    assert where.confirmed == Target(C, pen_down=True)
    assert where.distance_mm == 30.0
    assert where.trace.strokes[0].points == [(0.0, 0.0), (0.0, 10.0), (20.0, 10.0)]


@pytest.mark.parametrize(
    ("reply", "is_off"),
    [
        (m.HeadingReply(91), False),
        (m.HeadingReply(92), True),
        (m.XReply(42), False),
        (m.XReply(43), True),
        (m.YReply(18), False),
        (m.YReply(17), True),
        (m.LocationReply(42, 18), False),
        (m.LocationReply(43, 20), True),
        (m.LocationReply(40, 17), True),
        (m.PenReply(1), False),
        (m.PenReply(0), True),
        (m.TowardsReply(1), False),
    ],
)
def test_w11_an_answer_is_compared_within_the_robot_s_rounding(reply: m.RobotMessage, is_off: bool) -> None:
    where = account(A, B, C)
    where.compare(reply)
    assert where.in_doubt == is_off


def test_w5_coordinates_beyond_the_wire_are_not_compared() -> None:
    where = account(Pose(17000.0, -17000.0, 0.0))
    where.compare(m.LocationReply(32767, -32768))
    where.compare(m.XReply(32767))
    where.compare(m.YReply(-32768))
    assert not where.in_doubt


def test_w10_after_c_0_any_heading_will_do() -> None:
    where = account(Pose(0.0, 0.0, ANY_HEADING))
    where.compare(m.HeadingReply(123))
    assert not where.in_doubt


def test_while_something_is_uncertain_nothing_is_compared_or_counted() -> None:
    where = account(A)
    where.lost((Target(B, pen_down=True), None))
    where.done(Target(C, pen_down=True))
    assert (where.confirmed.pose, where.distance_mm) == (A, 10.0)
    where.in_doubt = False
    where.compare(m.HeadingReply(77))
    assert not where.in_doubt


def test_what_is_abandoned_is_in_doubt_no_more() -> None:
    where = account(A)
    where.lost(())
    where.forget()
    assert not where.in_doubt


def lossy() -> Whereabouts:
    """A confirmed; B and C lost, or not."""
    where = account(A)
    where.lost((Target(B, pen_down=True), Target(C, pen_down=True)))
    where.position.robot = C
    return where


def test_w15_the_pose_shows_that_everything_was_done() -> None:
    where = lossy()
    again, text = where.resolve(C)
    assert (again, where.confirmed.pose, where.distance_mm) == ([], C, 30.0)
    assert "every motion was done" in text
    assert where.corrections == 1


def test_w15_the_pose_shows_what_to_do_again() -> None:
    where = lossy()
    again, text = where.resolve(B)
    assert [target.pose for target in again] == [C]
    assert (where.confirmed.pose, where.position.robot) == (B, B)
    assert "1 commands got lost" in text
    assert [target.pose for target in lossy().resolve(A)[0]] == [B, C]


def test_w15_a_robot_elsewhere_goes_on_from_there_and_people_are_told() -> None:
    where = lossy()
    again, text = where.resolve(Pose(0.0, -40.0, 0.0))
    assert again == []
    assert "53.9 mm" in text
    assert where.position.robot == Pose(0.0, -40.0, 0.0)
    again, text = account(C).resolve(Pose(22.5, 10.0, 90.0))
    assert (again, text) == ([], "")
    again, text = account(C).resolve(Pose(21.5, 10.0, 90.0))
    assert (again, text) == ([], "")


def test_a_pen_that_contradicts_is_believed_twice() -> None:
    where = account(A)
    assert where.pen_disagrees() == ""
    assert where.pen_disagrees() == ""
    assert "contradict" in where.pen_disagrees()
    where.compare(m.PenReply(0))
    assert not where.in_doubt


def test_reckoning_after_a_stop() -> None:
    where = account(A)
    assert where.reckoned(None) == A
    assert where.reckoned((None, 0.5)) == A
    assert where.reckoned((Target(Pose(0.0, 30.0, 0.0), pen_down=True), 0.25)) == Pose(0.0, 15.0, 0.0)
    assert where.reckoned((Target(Pose(0.0, 10.0, 350.0), pen_down=True), 0.5)).heading_deg == 355.0


def test_reckoning_after_a_stop_on_the_way_home_and_there() -> None:
    """C 0 promises no heading: what is known of it is the last one."""
    home = Target(Pose(0.0, 0.0, ANY_HEADING), pen_down=True)
    where = account(Pose(0.0, 40.0, 90.0))
    assert where.reckoned((home, 0.5)) == Pose(0.0, 20.0, 90.0)
    where.done(home)
    assert where.reckoned(None) == Pose(0.0, 0.0, 90.0)
    turned = Target(Pose(0.0, 0.0, 0.0), pen_down=True)
    assert where.reckoned((turned, 0.5)) == Pose(0.0, 0.0, 45.0)


def test_a_place_keeps_what_is_finer_than_the_robot_can_tell() -> None:
    where = account(A)
    where.position.exact = Pose(0.2, 10.1, 0.4)
    where.place(A)
    assert where.position.exact == Pose(0.2, 10.1, 0.4)
    where.place(C)
    assert where.position.exact == C
    where.position.exact = Pose(20.0, 10.0, 80.0)
    where.place(C)
    assert where.position.exact == C


def test_poses_that_may_be_the_same() -> None:
    assert matches(HOME, Pose(1.4, 1.4, 359.0))
    assert not matches(HOME, Pose(1.5, 1.5, 0.0))
    assert not matches(HOME, Pose(0.0, 0.0, 2.0))


@pytest.mark.parametrize(
    ("pose", "points"),
    [
        (Pose(0.0, 4.0, 0.0), [(0.0, 0.0), (0.0, 4.0)]),  # within the first move
        (Pose(0.0, 10.0, 30.0), [(0.0, 0.0), (0.0, 10.0)]),  # within the turn
        (Pose(7.5, 10.0, 90.0), [(0.0, 0.0), (0.0, 10.0), (7.5, 10.0)]),  # within the second move
        (C, [(0.0, 0.0), (0.0, 10.0), (20.0, 10.0)]),  # at the end
    ],
)
def test_a_robot_that_was_cut_off_has_done_what_lies_before(
    pose: Pose, points: list[tuple[float, float]]
) -> None:
    where = Whereabouts()
    where.cut_off((Target(A, pen_down=True), None, Target(B, pen_down=True), Target(C, pen_down=True)), pose)
    assert where.trace.strokes[0].points == points
    assert where.trace.pose == pose
    assert where.confirmed == Target(pose, pen_down=True)


def test_the_pen_of_the_motion_that_was_cut_off_counts() -> None:
    where = Whereabouts()
    where.cut_off(
        (Target(A, pen_down=True), Target(B, pen_down=True), Target(C, pen_down=False)), Pose(7, 10, 90)
    )
    assert [stroke.pen_down for stroke in where.trace.strokes] == [True, False]


@pytest.mark.parametrize(
    "pose", [Pose(5.0, 5.0, 0.0), Pose(0.0, 4.0, 50.0), Pose(30.0, 10.0, 90.0), Pose(0, -5, 0)]
)
def test_a_robot_that_stands_beside_its_way_tells_nothing_of_it(pose: Pose) -> None:
    where = Whereabouts()
    where.cut_off((Target(A, pen_down=True), Target(B, pen_down=True), Target(C, pen_down=True)), pose)
    assert where.confirmed == Target(HOME, pen_down=True)
    assert where.trace.strokes == []


def test_a_robot_a_little_off_is_taken_at_its_word() -> None:
    where = account(A, B, C)
    where.compare(m.XReply(43))
    assert where.in_doubt
    assert where.resolve(Pose(21.5, 10.0, 90.0)) == ([], "")
    assert where.position.robot == Pose(21.5, 10.0, 90.0)
    where.compare(m.XReply(43))
    assert not where.in_doubt
