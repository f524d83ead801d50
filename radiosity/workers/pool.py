"""Worker processes of a local cluster, or of a scheduler elsewhere."""

import ipaddress
import logging
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from urllib.parse import urlsplit

import dask
from distributed import Client, KilledWorker, LocalCluster, as_completed
from distributed.comm import CommClosedError
from distributed.security import Security

from golden.base.errors import InputError
from golden.base.spread import Spread
from golden.scene.scene import Scene
from radiosity.workers.parcel import Parcel
from radiosity.workers.proof import Proof
from radiosity.workers.remote import known_objects, run_span

__all__ = ["WorkerPool"]

# Seconds in which a scheduler must answer, and a first worker connect to it.
_ANSWER = 30
_SETTINGS = {
    "distributed.worker.profile.enabled": False,
    # A scene of many patches is one large argument, on purpose.
    "distributed.admin.large-graph-warning-threshold": "1TiB",
}


class WorkerPool:
    """Processes that compute spans of work; a context manager.

    Each worker holds the scene and its own caster. A span whose worker dies goes to another one.

    Parameters
    ----------
    workers
        The number of processes with one thread each to start on this machine, or the address of a scheduler, such as
        ``tls://host:8786``. Only loopback addresses may begin with ``tcp://``.
    method, cell
        How the workers cast, see `golden.engine.cast.methods.frustum_caster`.

    Raises
    ------
    InputError
        No scheduler answers, it has no workers, a connection is not encrypted, or a worker would give other bytes.
    """

    def __init__(self, workers: int | str, *, method: str, cell: float | None = None):
        self._workers, self._method, self._cell = workers, method, cell
        self._where = "this machine" if isinstance(workers, int) else f"scheduler {workers}"
        self._open = ExitStack()

    def __enter__(self):
        with ExitStack() as opened, self._failures():
            opened.enter_context(dask.config.set(_SETTINGS))
            opened.enter_context(_quiet())
            if isinstance(self._workers, int):
                # Without a limit of memory, as in one process; loopback for the pages on its state too.
                address = opened.enter_context(LocalCluster(
                    n_workers=self._workers, threads_per_worker=1, memory_limit=None, host="127.0.0.1",
                    dashboard_address="127.0.0.1:0", scheduler_kwargs={"dashboard": False},
                    silence_logs=logging.CRITICAL))
            else:
                address = self._workers
                _check_encrypted(address, "scheduler")
            self._client = opened.enter_context(Client(address, timeout=_ANSWER, set_as_default=False))
            self._proof = Proof.of_this_process(self._method)
            self._check_workers()
            self._open = opened.pop_all()
        return self

    def __exit__(self, *error):
        return self._open.__exit__(*error)

    def spread(self, scene: Scene, *, frusta, rays) -> Spread:
        """A `Spread` over the workers, for functions that refer to a scene and to its casters of frusta and rays."""
        known = known_objects(scene, frusta, rays)

        def spread(function, parts):
            with self._failures():
                held = [self._hold(Parcel.of(replace(scene), {})), self._hold(Parcel.of(function, known))]
                futures = {self._client.submit(run_span, self._proof, self._cell, *held, *part, pure=False): part
                           for part in parts}
                for future, result in as_completed(futures, loop=self._client.loop, with_results=True):
                    # The scheduler is lost: the result is the error, which is not raised.
                    if future.cancelled():
                        raise result
                    yield futures.pop(future), result
        return spread

    def _hold(self, parcel):
        """The parcel as the result of a task, so that the scheduler can replace it when its worker dies."""
        return self._client.submit(Parcel, parcel.digest, parcel.content, key=f"parcel-{parcel.digest}")

    def _check_workers(self):
        """All present workers are reached safely and give this process' bytes; work itself checks later ones."""
        try:
            self._client.wait_for_workers(1, timeout=_ANSWER)
        except TimeoutError as error:
            raise InputError(f"workers: {self._where} has none") from error
        for address in self._client.scheduler_info(n_workers=-1)["workers"]:
            _check_encrypted(address, "worker")
        for address, error in self._client.run(self._proof.check, on_error="return").items():
            if isinstance(error, InputError):
                raise error
            if error is not None:
                raise InputError(f"worker {address}: it cannot run this version of radiosity-engine: {error}")

    @contextmanager
    def _failures(self):
        """Errors of one line instead of those of the network and of workers."""
        try:
            yield
        except KilledWorker as error:
            raise InputError(f"workers: {error.allowed_failures + 1} of them died in the same span of work") from error
        except ImportError as error:
            raise InputError(f"workers: they cannot run this version of radiosity-engine ({error})") from error
        except (CancelledError, CommClosedError) as error:
            raise InputError(f"workers: the connection to {self._where} was lost") from error
        except OSError as error:
            raise InputError(f"workers: {self._where} cannot be reached: {error}") from error


@contextmanager
def _quiet():
    """Without the log of dask, which reports each lost connection several times."""
    loggers = [logging.getLogger(name)
               for name in ("distributed", "distributed.client", "distributed.nanny", "tornado")]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _check_encrypted(address, what):
    parts = urlsplit(address)
    if parts.scheme != "tls" and not _is_loopback(parts.hostname):
        raise InputError(f"workers: {what} {address}: Address must begin with tls:// unless it is a loopback one")
    if parts.scheme == "tls" and Security().get_connection_args("client").get("ssl_context") is None:
        raise InputError(f"workers: {what} {address}: no certificate; dask's settings distributed.comm.tls name it")


def _is_loopback(host):
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:  # a name that may mean anything
        return False
