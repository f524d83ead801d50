"""The error of a single patch."""

from golden.base.errors import InputError

__all__ = ["PatchError"]


class PatchError(InputError):
    """A patch's values cannot be used.

    Parameters
    ----------
    patch
        Its number, from 0.
    fault
        What is wrong, without the patch.
    parameter
        The parameter of the value that is wrong, or None.
    """

    def __init__(self, patch: int, fault: str, *, parameter: str | None = None):
        super().__init__(f"exchange: patch {patch}: {fault}", parameter=parameter)
        self.patch, self.fault = patch, fault
