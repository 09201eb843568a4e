"""The plan of the house: what each room holds, and what it may import.

A room is a folder of `warprock/`, or a module at its top. Rooms are listed from the ground up: each
imports only rooms above it in this list. `tests/test_architecture.py` holds the sources to it, and
the map in the README is printed by

    python tools/house.py
"""

from __future__ import annotations

import textwrap
from typing import NamedTuple


class Room(NamedTuple):
    """One room.

    Attributes:
        name: Its folder, or its module.
        holds: What a stranger finds there.
        imports: Rooms that it may import besides itself.
        packages: Packages of others that it may import.
    """

    name: str
    holds: str
    imports: tuple[str, ...] = ()
    packages: tuple[str, ...] = ()


def _room(name: str, holds: str, imports: str = "", packages: str = "") -> Room:
    return Room(name, " ".join(holds.split()), tuple(imports.split()), tuple(packages.split()))


_BASE = "errors arguments unmodelled units quantity reading plugins model settings"

ROOMS = (
    _room("errors", "errors that a user can mend, each in one line, and what they suggest"),
    _room("arguments", "arguments of public functions, judged by their annotations", "errors"),
    _room("unmodelled", "words for what is not modelled, and what is nearest to each"),
    _room("units", "numbers with units, read and written"),
    _room("reading", "files as they are read, of a bounded size"),
    _room("processes", "worker processes that end when the work does"),
    _room(
        "quantity",
        "kinds of values that a key may hold, with bounds",
        "errors units",
        "pydantic_core",
    ),
    _room("cases", "shipped cases and data, one folder a case"),
    _room(
        "kernels",
        """Warp only, one folder a scheme (`NAME_space` in space): `block`, `body`, `stack`, and
        `*_run`, the loop over lanes; what they share in `shape`, `contact`, `motion`, `lane`,
        `algebra`, `launch`""",
        "",
        "warp",
    ),
    _room(
        "model",
        "the arrays that rooms hand one another (lanes, motions, scene, response); closed forms",
        "errors units",
        "numpy scipy",
    ),
    _room("plugins", "engines that other packages bring, by entry points", "errors"),
    _room(
        "settings",
        "settings of engines and of programs of others, with bounds",
        "errors unmodelled units quantity plugins",
        "pydantic",
    ),
    _room(
        "recordings",
        "files of ground motion: formats, processing, intensity measures, synthetic records",
        "errors units quantity reading processes model",
        "numpy pyarrow scipy tables",
    ),
    _room(
        "drawings",
        "files of polygons: drawings in DXF, blocks of COMPAS, faces in OBJ",
        "errors quantity reading",
        "ezdxf numpy scipy",
    ),
    _room(
        "case",
        """case.toml -> lanes and ground motions: one file a table ([block] in `block.py`), where
        each key is declared""",
        f"{_BASE} recordings drawings",
        "numpy pandas pydantic pydantic_core scipy",
    ),
    _room(
        "bodies",
        """bodies from meshes: mass, centre, inertia, poses at rest, contact points, and the case of
        each""",
        f"{_BASE} recordings case",
        "numpy scipy trimesh",
    ),
    _room(
        "engines",
        "engines by name, one file a scheme: launch of its kernels, decoding, soundness of lanes",
        "errors units plugins model settings kernels",
        "numpy warp",
    ),
    _room(
        "oracle",
        "references in SciPy for one and two blocks; they share no formula with the kernels",
        "units processes model",
        "numpy scipy",
    ),
    _room(
        "programs",
        "the same lanes in MuJoCo, Bullet, Blender and Newton; plain loops",
        "errors units model settings",
        "bpy mujoco newton numba numpy pybullet scipy warp",
    ),
    _room(
        "running",
        """lanes in chunks over threads, refined until within a tolerance; runs, their tables and
        files; which engine""",
        f"{_BASE} kernels case engines programs",
        "numpy pandas pyarrow scipy warp",
    ),
    _room(
        "sweeps",
        "plans of many lanes; chunks that are resumed, spread over machines and merged",
        f"{_BASE} case running",
        "distributed pyarrow",
    ),
    _room(
        "analysis",
        """fragility, yearly rates, IDA, overturning maps, rocking spectra, Sobol' indices, free
        rocking, statics""",
        f"{_BASE} case running sweeps",
        "numpy pandas pyarrow scipy",
    ),
    _room(
        "verification",
        """engines against Housner, the oracle, programs of others and observed tests; checks of the
        cases; studies""",
        f"{_BASE} case engines running analysis oracle programs",
        "numpy pandas pyarrow",
    ),
    _room(
        "measure",
        "what accuracy costs (trade), the atlas of extremes, speed (bench), the machine (doctor)",
        f"{_BASE} recordings case engines running verification oracle programs",
        "numpy pandas pyarrow warp",
    ),
    _room(
        "findings",
        "what came out, told once in sentences and tables, for terminal, page, figures and Python",
        f"{_BASE} case bodies running sweeps analysis verification measure",
        "numpy pandas",
    ),
    _room(
        "report",
        "the page of a folder of results: one HTML file, its template, style and player",
        f"{_BASE} case running sweeps analysis verification findings",
        "PIL jinja2 markupsafe numpy pandas pyarrow",
    ),
    _room(
        "tables",
        "tables on the terminal",
        f"{_BASE} case bodies running sweeps analysis verification findings",
        "numpy pandas rich",
    ),
    _room(
        "figures",
        "figures, drawn before they are written: one style, one file a kind",
        f"{_BASE} case bodies running analysis verification findings tables",
        "matplotlib numpy pandas",
    ),
    _room(
        "scenes",
        "moving pictures of a lane as files (GIF, MP4, glTF, USD), and Newton's viewers",
        f"{_BASE} case running figures",
        "PIL imageio_ffmpeg imgui_bundle newton numpy warp",
    ),
    _room(
        "paper",
        "all that serves only the seed paper: its printed numbers, ours beside them, its conflicts",
        f"{_BASE} case engines running report analysis verification oracle findings tables figures",
        "numpy pandas rich",
    ),
    _room(
        "api",
        "`import warprock`: cases from Python objects; commands as functions; what they find",
        f"""{_BASE} recordings case bodies running sweeps analysis verification measure findings
        tables figures report""",
        "numpy pandas",
    ),
    _room(
        "cli",
        "the commands, made of the functions of api where these say all, and how they end",
        f"""{_BASE} recordings case bodies running sweeps analysis verification measure findings
        tables figures scenes paper report api""",
        "click",
    ),
)
"""All rooms, from the ground up."""

MODULES = (
    *("errors", "arguments", "unmodelled", "units", "processes", "reading", "quantity"),
    "plugins",
)
"""Rooms that are one module at the top of `warprock/`."""

MAPPED = ("kernels", "cases")
"""Rooms that lie beside `warprock/` in a checkout, and in it when installed."""


def readme_map() -> str:
    """The map of the house as the README shows it."""
    width, lines = 128, []
    for room in ROOMS:
        folder = "" if room.name in MAPPED else "warprock/"
        head = f"{folder + room.name + ('.py' if room.name in MODULES else '/'):<22} "
        lines += textwrap.wrap(
            room.holds, width, initial_indent=head, subsequent_indent=" " * len(head)
        )
    rest = "tests of a module by its path; tools/ for those who move walls. Nothing imports them"
    return "\n".join([*lines, f"{'tests/ tools/':<22} {rest}"])


if __name__ == "__main__":
    print(readme_map())
