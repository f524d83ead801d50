"""A chart of the utilization of each unit during a cast."""

from pathlib import Path

from golden.config import Config
from hw.simulator.utilization import utilization
from radiosity.chart import Line, write_chart

__all__ = ["write_timeline"]


def write_timeline(path: Path, samples: list, config: Config, *, title: str) -> None:
    """Write the chart of samples as `hw.simulator.utilization` takes them."""
    at, busy = utilization(samples, config)
    write_chart(path, [Line(name=name, x=at, y=values) for name, values in busy.items()], title=title,
                x_name="cycle", y_name="share of cycles", y_top=1.0)
