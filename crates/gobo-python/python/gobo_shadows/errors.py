"""Errors and warnings. Every error states its remedy, if one is known."""

from __future__ import annotations


class GoboError(Exception):
    """Base of all errors of this package.

    Attributes:
        message: the problem.
        remedy: what to do about it, or ``None``.
    """

    def __init__(self, message: str, remedy: str | None = None) -> None:
        self.message = message
        self.remedy = remedy or None
        super().__init__(message, self.remedy)

    def __str__(self) -> str:
        return f"{self.message}\n  help: {self.remedy}" if self.remedy else self.message


class InputError(GoboError, ValueError):
    """An invalid array, table or number."""


class SceneError(GoboError):
    """A file that cannot be read or is invalid.

    Attributes:
        path: the file, or ``None``.
        line: line of a scene file, from 1, or ``None``.
        column: column in that line [characters], from 1, or ``None``.
    """

    path: str | None = None
    line: int | None = None
    column: int | None = None


class AdapterError(GoboError):
    """No usable adapter, or one whose limits are too small."""


class DeviceError(GoboError):
    """A device that stopped answering, or refused a command."""


class OutOfMemoryError(GoboError, MemoryError):
    """Not enough memory, of this machine or of the device."""


class GoboWarning(UserWarning):
    """Inputs left out, not read, or copied from a GPU.

    ``warnings.simplefilter("error", GoboWarning)`` makes it an error.
    """
