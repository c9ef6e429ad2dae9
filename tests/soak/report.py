"""What a soak has seen."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, fields
from typing import Any


@dataclass
class Report:
    """Figures of one life of a robot, or of many.

    Attributes:
        robot: whose.
        lives: how often everything began anew; steps: things done; commands: of the driver's among them.
        wire_commands: commands that the host sent; bytes_to_robot: in how many bytes.
        executed: commands that the robot carried out as they were sent.
        faults: what was done to bytes, by direction and fault.
        stops, resets, links_lost, reconnections, stalls: how often those happened.
        noticed: how the host noticed that something was wrong; notices: what people were told.
        recoveries: how often all was brought in order again; worst_bytes, worst_s: what that took at most.
        calm_worst_bytes, calm_worst_s: the same of recoveries that nothing disturbed.
        uncatchable: what no host could notice by this wire, by kind.
        errors: what the driver's commands raised.
        virtual_s: of the robot's time; seconds: of the computer's.
    """

    robot: str
    lives: int = 0
    steps: int = 0
    commands: int = 0
    wire_commands: int = 0
    bytes_to_robot: int = 0
    executed: int = 0
    stops: int = 0
    resets: int = 0
    links_lost: int = 0
    reconnections: int = 0
    stalls: int = 0
    notices: int = 0
    recoveries: int = 0
    worst_bytes: int = 0
    worst_s: float = 0.0
    calm_worst_bytes: int = 0
    calm_worst_s: float = 0.0
    virtual_s: float = 0.0
    seconds: float = 0.0
    faults: Counter[str] = field(default_factory=Counter)
    noticed: Counter[str] = field(default_factory=Counter)
    uncatchable: Counter[str] = field(default_factory=Counter)
    errors: Counter[str] = field(default_factory=Counter)

    def add(self, other: Report) -> None:
        """Count another one in."""
        for each in fields(self):
            mine, its = getattr(self, each.name), getattr(other, each.name)
            if each.name.startswith(("worst", "calm_worst")):
                setattr(self, each.name, max(mine, its))
            elif each.name != "robot":
                setattr(self, each.name, mine + its)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            each.name: dict(value.most_common())
            if isinstance(value := getattr(self, each.name), Counter)
            else value
            for each in fields(self)
        }

    def table(self) -> str:
        """For people."""
        lines = [f"soak of {self.robot}"]
        for name, value in self.as_dict().items():
            if isinstance(value, dict):
                lines.append(f"  {name.replace('_', ' ')}: {sum(value.values()):,}")
                lines += [f"    {count:>9,}  {what}" for what, count in value.items()]
            elif name != "robot":
                shown = f"{value:,.1f}" if isinstance(value, float) else f"{value:,}"
                lines.append(f"  {name.replace('_', ' ')}: {shown}")
        return "\n".join(lines)
