"""The option ``--workers``."""

from contextlib import AbstractContextManager, nullcontext
from urllib.parse import urlsplit

import click

__all__ = ["WORKERS", "Workers", "worker_pool"]

_MOST = 256


class Workers(click.ParamType):
    """A number of processes, as int, or the address of a scheduler with its protocol, host and port."""

    name = "N|ADDRESS"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, int):
            return value
        if value.isascii() and value.isdigit() and 1 <= int(value) <= _MOST:
            return int(value)
        address = value if "://" in value else f"tcp://{value}"
        try:
            parts = urlsplit(address)
            if parts.scheme in ("tcp", "tls") and parts.hostname and parts.port:
                return address
        except ValueError:  # a port that is no number
            pass
        return self.fail(f"{value!r} is neither a number of processes from 1 to {_MOST} nor an address like "
                         "tls://host:8786", param, ctx)


WORKERS = click.option("--workers", type=Workers(), help="Compute in so many processes with one thread each, or by the "
                       "workers of a dask scheduler. The output does not depend on it.  [default: threads]")


def worker_pool(workers: int | str | None, method: str, machine, *, cell: float | None) -> AbstractContextManager:
    """The pool of ``--workers``, or None if the option is not given; ``machine``: the simulated one, if it casts.

    Raises
    ------
    click.UsageError
        The machine casts in one process alone.
    """
    if workers is None:
        return nullcontext()
    if machine:
        raise click.UsageError(f"--workers excludes --method {method}.", click.get_current_context())
    from radiosity.workers.pool import WorkerPool

    return WorkerPool(workers, method=method, cell=cell)
