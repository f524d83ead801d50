"""A chart of the utilization of each unit during a cast."""

from pathlib import Path

from golden.engine.config import Config
from radiosity.charts.chart import Line, write_chart
from radiosity.flow.simulator.utilization import utilization

__all__ = ["write_timeline"]


def write_timeline(path: Path, samples: list, config: Config, *, title: str) -> None:
    """Write the chart of samples as `radiosity.flow.simulator.utilization` takes them."""
    at, busy = utilization(samples, config)
    write_chart(path, [Line(name=name, x=at, y=values) for name, values in busy.items()], title=title,
                x_name="cycle", y_name="share of cycles", y_top=1.0)
