"""Errors that a user can mend."""

from __future__ import annotations


class InputError(ValueError):
    """Input that cannot be used, said in one line: file, key, value and bound.

    The command line prints it and exits with 2 before anything runs or is written.
    """

    def __init__(self, source: str, key: str, got: object, allowed: str) -> None:
        """Says what is wrong.

        Args:
            source: File or option that holds the input.
            key: Dotted key inside it; may be empty.
            got: The value as the user wrote it.
            allowed: What would be allowed, with its unit.
        """
        self.source, self.key, self.got, self.allowed = source, key, got, allowed
        place = f"{source}: {key}" if key else source
        super().__init__(f"{place}: got {got!r}, {allowed}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, object, str]]:
        """How a process hands the error to another one: by what it was made of."""
        return type(self), (self.source, self.key, self.got, self.allowed)
