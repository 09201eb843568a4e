"""What this machine offers: the function, which the command of its name calls."""

from __future__ import annotations

import functools

from warprock.api.looked_up import LookedUp
from warprock.arguments import at_the_door
from warprock.findings.listing import find_examination
from warprock.measure.doctor import examine
from warprock.tables.machine import print_examination


@at_the_door
def doctor() -> LookedUp:
    """Versions, cores, vector instructions, Warp devices, kernel cache, and what is missing.

    Returns:
        A `Found` whose tables are `engines`, `packages` and `devices`; `missing` of its facts has
        a sentence for each thing to mend, `notes` for each thing that only costs speed.

    Example:
        >>> import warprock as wr
        >>> wr.doctor().facts["missing"]
        []
    """
    found = examine()
    find = functools.partial(find_examination, found, print_examination)
    return LookedUp("this machine", found, find)
