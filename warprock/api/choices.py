"""What there is to choose from: the function, which the command of its name calls."""

from __future__ import annotations

import functools

from warprock.api.looked_up import LookedUp
from warprock.arguments import at_the_door
from warprock.findings.listing import find_list
from warprock.running.choices import list_all
from warprock.tables.listing import print_listing


@at_the_door
def list() -> LookedUp:
    """The shipped cases and the engines.

    Returns:
        A `Found` whose tables are `cases`, `engines` and `programs`, those of others that
        `compare` runs beside them.

    Example:
        >>> import warprock as wr
        >>> found = wr.list()
        >>> "free-b0" in found.table["name"].tolist()
        True
        >>> found.tables["engines"].columns.tolist()
        ['name', 'order', 'summary']
    """
    found = list_all()
    return LookedUp("cases and engines", found, functools.partial(find_list, found, print_listing))
