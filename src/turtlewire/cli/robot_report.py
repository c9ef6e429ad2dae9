"""What people, or programs, are told of one robot of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from turtlewire.cli.progress import duration

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from turtlewire.configuration import Target
    from turtlewire.connect import Robot
    from turtlewire.deviation import Followed
    from turtlewire.links.link import Link
    from turtlewire.turtle import Pose

# What is compared with the exact path.
DRAWINGS = {
    "seen": "as seen",
    "reported": "as the robot reports its way",
    "reckoned": "by reckoning; the robot cannot tell its way",
}
# What a JSON object tells of a robot: nothing yet.
UNKNOWN: dict[str, Any] = {
    "statistics": None,
    "robot_pose": None,
    "host_pose": None,
    "deviation_mm": None,
    "drawing": None,
}


class RobotReport:
    """Gathers what is known of one robot.

    Args:
        target: which robot it is.

    Attributes:
        is_real: it is a real one, or somebody else's: it takes its own time, and has to be stopped.
        is_reachable: whether there is a link to it, when all is over.
        result: what a JSON object tells of it.
        connection: what its connection was like, once somebody has asked for that.
    """

    def __init__(self, target: Target) -> None:
        self._target = target
        self._link: Link | None = None
        self.is_real = not target.is_simulated
        self.is_reachable = True
        self.connection: dict[str, Any] = {}
        self.result = dict(UNKNOWN)

    def see(self, link: Link) -> Link:
        """The link to it, as it is."""
        self._link = link
        return link

    def finished(self, robot: Robot) -> None:
        """The program is done: where is the robot, and where does it say that it is, if it can?"""
        from turtlewire.robots.walter import Walter

        if isinstance(robot, Walter) and "Q" in robot.groups:
            self.result["robot_pose"] = robot.reported_pose()._asdict()
        self.result["host_pose"] = robot.pose._asdict()

    def deviates(self, robot: Robot, turtle: Followed, origin: Pose) -> None:
        """What was drawn is compared with what should have been; ``origin``: the turtle's home, as the drawing has it.

        For a robot that cannot be seen, what was drawn is where it says that it went, or where it should have gone.
        """
        from turtlewire.deviation import between

        says = "Q" in getattr(robot, "groups", ())
        self.result["drawing"] = (
            "reported" if says and self.is_real else "reckoned" if self.is_real else "seen"
        )
        found = between(robot.trace, turtle.ideal, origin) if turtle.is_exact else None
        self.result["deviation_mm"] = found and found._asdict()

    def measure(self, robot: Robot) -> None:
        """The figures of the connection, however far it came."""
        self.result["statistics"] = robot.statistics._asdict()

    def describe(self) -> None:
        """What the connection was like: what people can put into a bug report."""
        import platform
        from importlib.metadata import version

        from turtlewire.links.faults import FaultyLink

        target, link = self._target, self._link
        self.connection = {
            "turtlewire": version("turtlewire"),
            "system": f"Python {platform.python_version()} on {platform.platform()}",
            "robot": target.protocol,
            "port": target.port,
            "settings": {**target.simulation, **{k: str(v) for k, v in target.overrides.items()}},
        }
        if isinstance(link, FaultyLink):
            self.connection["faults"] = {
                name: getattr(link, name) for name in ("lost", "added", "flipped", "duplicated")
            }
        self.result["connection"] = self.connection

    # ------------------------------------------------------------------ for people

    def summary(self, host_s: float) -> Iterator[str]:
        """How it went, a line each; ``host_s``: how long the run took here, in seconds."""
        figures, robot = self.result["statistics"], self.result["robot_pose"]
        # Those that are driven by set-points have neither commands to count nor a pose to tell.
        answers = "commands" in figures
        robot_s = figures["seconds"]
        counted = (
            f"{figures['commands']} commands ({figures['fences']} of them fences) in " if answers else ""
        )
        yield f"  sent       {counted}{figures['bytes_sent']} bytes; {figures['bytes_received']} bytes came back"
        yield f"  driven     {figures['distance_mm'] / 1000:.2f} m in {duration(robot_s)} of the robot's time"
        if not self.is_real:
            yield f"  took       {duration(host_s)} ({robot_s / host_s:.0f} times as fast as the robot)"
        yield f"  host pose  {_pose(self.result['host_pose'])}"
        if answers:
            yield f"  robot pose {_pose(robot) if robot else 'it cannot tell'}"
        yield from self._deviation()
        if figures.get("corrections"):
            yield f"  corrected  {figures['corrections']} times: the robot was not where it should have been"

    def _deviation(self) -> Iterator[str]:
        deviation, drawing = self.result["deviation_mm"], self.result["drawing"]
        if deviation:
            yield (
                f"  deviation  {deviation['largest']:.2f} mm at most, {deviation['mean']:.2f} mm on average, "
                f"from the exact path ({DRAWINGS[drawing]})"
            )

    def state(self, which: str = "The robot") -> Iterator[str]:
        """After an error: what became of it, if that is not only a simulated one; ``which`` robot it is."""
        figures = self.result["statistics"]
        if figures is None or not self.is_real:
            return
        if self.is_reachable:
            yield f"{which} was stopped, after {figures['distance_mm'] / 1000:.2f} m."
        else:
            yield f"{which} cannot be reached to stop it: if it still moves, switch it off."

    def statistics(self) -> Iterator[str]:
        """The figures of its connection, a line each."""
        return _lines(self.connection | (self.result["statistics"] or {}))


def _pose(pose: dict[str, float]) -> str:
    # + 0.0 makes a plain zero of a negative one.
    x, y, heading = (round(pose[key], 3) + 0.0 for key in ("x_mm", "y_mm", "heading_deg"))
    return f"x {x:g} mm, y {y:g} mm, heading {heading % 360.0:g} degrees"


def _lines(figures: Mapping[str, object]) -> Iterator[str]:
    for name, value in figures.items():
        if isinstance(value, dict):
            text = ", ".join(f"{key} {part}" for key, part in value.items()) or "as by default"
        else:
            text = f"{value:.10g}" if isinstance(value, float) else "-" if value is None else str(value)
        yield f"  {name:20} {text}"
