"""What may be written in a case file: the function, which the command of its name calls."""

from __future__ import annotations

import functools

from warprock.api.looked_up import LookedUp
from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.case.reference import find_sections
from warprock.findings.keys import find_keys
from warprock.tables.keys import print_keys


@at_the_door
def keys(table: str | None = None) -> LookedUp:
    """Keys of a case file: bounds, units, meaning, whether they may be swept, their columns.

    Args:
        table: A table, such as `block` or `engines.dem`, or a key, such as `block.height`; all
            without it.

    Returns:
        A `Found` whose table has one row a key.

    Raises:
        InputError: There is no such table or key.

    Example:
        >>> import warprock as wr
        >>> wr.keys("contact.friction").table[["key", "unit", "required"]].values.tolist()
        [['contact.friction', 'number or angle', True]]
    """
    with python_names():
        found = find_sections(table)
    title = table or "keys of a case file"
    return LookedUp(title, found, functools.partial(find_keys, found, print_keys))
