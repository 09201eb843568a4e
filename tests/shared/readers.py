"""What the readers of pelicun and of the OpenQuake engine make of our files, as one JSON object.

Both want other packages than ours, so that they have an environment of their own, in which
`.ci/outside` runs this file alone:

    python readers.py pelicun fragility-p58.csv
    python readers.py openquake fragility.xml 0.1 0.5 1.0

The second prints the probabilities that OpenQuake finds at these intensities, in its units.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any


def read_pelicun(path: str) -> dict[str, Any]:
    """Parameters of every limit state by component, in pelicun's units (SI)."""
    from pelicun.assessment import Assessment

    with open(path, encoding="utf-8") as file:
        names = {line.partition(",")[0] for line in file.read().splitlines()[1:]}
    theirs = Assessment({"PrintLog": False})
    theirs.damage.load_model_parameters([path], names, warn_missing=False)
    table = theirs.damage.ds_model.damage_params
    found: dict[str, Any] = {}
    for name, row in table.iterrows():
        mine = found.setdefault(str(name), {})
        for key, value in row.items():
            if len(key) == 2 and str(key[1]).startswith("Theta_") and value == value:
                mine[f"{key[0]}-{key[1]}"] = float(value)
    return found


def read_openquake(path: str, levels: list[float]) -> dict[str, Any]:
    """Measure and probabilities at some intensities, by function and limit state."""
    # What it compiles as it is imported takes a minute, and nothing here needs it.
    os.environ["NUMBA_DISABLE_JIT"] = "1"

    from openquake.hazardlib import nrml
    from openquake.risklib import scientific  # noqa: F401  the reader of models, once imported

    model = nrml.to_python(path)
    return {
        name: {
            "imt": imt,
            "limits": list(model.limitStates),
            "chances": [each(levels).tolist() for each in functions.build(model.limitStates)],
        }
        for (imt, name), functions in model.items()
    }


if __name__ == "__main__":
    which, path, *rest = sys.argv[1:]
    answer = read_pelicun(path) if which == "pelicun" else read_openquake(path, [*map(float, rest)])
    print(json.dumps(answer))
