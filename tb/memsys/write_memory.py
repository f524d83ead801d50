"""Main memory behind streams of requests and data: what is written, and the answers."""

from collections import deque
from collections.abc import Container, Iterable

__all__ = ["WriteMemory"]


class WriteMemory:
    """Stores the beats of one request after the other, and answers a request with its last beat.

    Parameters
    ----------
    data_bits
        Of a beat.
    requests
        Those that are known to come, and after the last one again.
    fails
        Numbers of the requests that are answered with an error; their beats are not stored.

    Members
    -------
    bytes
        What has been written, by address.
    requests
        All requests; ``answered`` is how many of them have all their data.
    """

    def __init__(self, data_bits: int, requests: Iterable[dict] = (), *, fails: Container[int] = ()):
        self._size, self._fails = data_bits // 8, fails
        self._known, self._waiting, self._beat = tuple(requests), deque(), 0
        self.bytes, self.requests, self.answered = {}, [], 0

    def request(self, value: dict) -> list:
        """A request; it has no answer yet."""
        assert value["address"] % self._size == 0
        self._waiting.append(value)
        self.requests.append(value)
        return []

    def data(self, value: dict) -> list:
        """A beat of the oldest request, and the answer if it is the last one."""
        if not self._waiting:
            self._waiting.extend(self._known)
        assert self._waiting, "data came before their request"
        head = self._waiting[0]
        address = head["address"] + self._size * self._beat
        if self.answered not in self._fails:
            self.bytes |= {address + k: value["data"] >> 8 * k & 0xFF for k in range(self._size)
                           if value["strobe"] >> k & 1}
        self._beat += 1
        if self._beat <= head["length"]:
            return []
        self._waiting.popleft()
        self._beat = 0
        self.answered += 1
        return [{"tag": head["tag"], "error": int(self.answered - 1 in self._fails)}]
