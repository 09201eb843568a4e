"""What a case asks for: the function, which the command of its name calls."""

from __future__ import annotations

import functools

from warprock.api.case import AnyCase, any_case
from warprock.api.looked_up import LookedUp
from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.case.load import Overrides
from warprock.findings.listing import find_explanation
from warprock.running import catalogue
from warprock.tables.listing import print_explanation


@at_the_door
def explain(case: AnyCase, *, overrides: Overrides = ()) -> LookedUp:
    """What a case requires, and which kernels can run it.

    Args:
        case: The case, as in `run`.
        overrides: As in `run`.

    Returns:
        A `Found` whose table has one row an engine: the kernel that it would run, or why it
        declines. Its facts say what the scene is, and the values of every input.

    Raises:
        InputError: The case cannot be used.

    Example:
        >>> import warprock as wr
        >>> found = wr.explain("free-b0")
        >>> found.facts["lanes"], found.facts["engine"]["engine"]
        (2, 'housner')
    """
    with python_names():
        found = catalogue.explain_case(any_case(case, overrides).judged)
    find = functools.partial(find_explanation, found, print_explanation)
    return LookedUp(f"{found['case']['name']}: what it requires", found, find)
