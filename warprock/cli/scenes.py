"""The commands `animate` and `view`: a lane in motion, as a file and in a viewer."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING

import click

from warprock.cli.options import json_option, list_written, output_file_to

if TYPE_CHECKING:
    from warprock.running.scene_motion import SceneMotion

FORMS = (".gif", ".mp4", ".png", ".glb", ".usd", ".usda", ".usdc")
MOST_FRAMES = 3000
FASTEST = 1000.0

_FOLDER = click.argument("folder", metavar="DIR", type=click.Path(path_type=pathlib.Path))
_LANE = click.option(
    "--lane", type=int, default=0, show_default=True, help="Number of the lane, from 0."
)


def _speed(_context: click.Context, _option: click.Parameter, speed: float) -> float:
    """A speed, refused where it is none."""
    from warprock.errors import InputError

    if not 0.0 < speed <= FASTEST:
        raise InputError("--speed", "", speed, f"must be above 0 and at most {FASTEST:g}")
    return speed


_SPEED = click.option(
    "--speed",
    type=float,
    callback=_speed,
    default=1.0,
    show_default=True,
    help="Seconds of the lane in a second: 0.25 is slow motion.",
)


@click.command()
@_FOLDER
@_LANE
@output_file_to(
    "path",
    "File to write; its ending says the form: .gif, .mp4, .png (one picture, of the largest "
    "rotation), .glb (glTF), .usd, .usda or .usdc. DIR/lane-N.gif where it is not given.",
)
@_SPEED
@click.option(
    "--rate",
    type=click.IntRange(1, 120),
    default=25,
    show_default=True,
    help="Pictures a second.",
)
@json_option
def animate(
    folder: pathlib.Path,
    lane: int,
    path: pathlib.Path | None,
    speed: float,
    rate: int,
    as_json: bool,
) -> None:
    """Make a moving picture of a lane of the run or sweep in DIR: its blocks, its base, and time.

    What holds a block and what supports its base is shown, too. The lane runs again, alone, at the
    step of its numbers. GIF, PNG and glTF need nothing besides; MP4 needs the extra `movie`, USD
    the extra `usd`.
    """
    from warprock.errors import InputError
    from warprock.running.files import require_writable_file
    from warprock.scenes.needs import require_package
    from warprock.tables.terminal import print_json, print_written

    target = path or folder / f"lane-{lane}.gif"
    form = target.suffix.lower()
    if form not in FORMS:
        raise InputError("--output", "", str(target), f"must end in one of {', '.join(FORMS)}")
    require_package("--output", "usd" if form.startswith(".usd") else form[1:])
    require_writable_file(target)
    motion = _motion(folder, lane, speed / rate)
    target.parent.mkdir(parents=True, exist_ok=True)
    _write(target, motion, rate)
    if path is None:
        list_written(folder, [target], beside=True)
    print_json({"files": [str(target)]}) if as_json else print_written([target])


def _motion(folder: pathlib.Path, lane: int, interval: float) -> SceneMotion:
    """A lane of a folder, run again.

    Raises:
        InputError: There is no such lane, or it would take too many pictures.
    """
    from warprock.errors import InputError, Said
    from warprock.findings.kinds import shapes
    from warprock.running.results import PROVENANCE
    from warprock.running.scene_motion import run_of_folder, scene_motion
    from warprock.sweeps.lane import run_of_lane
    from warprock.sweeps.plan import PLAN, read_plan

    ran = (folder / PROVENANCE).is_file() or not (folder / PLAN).is_file()
    if ran:
        run = run_of_folder(folder, shapes())
        case, count = run.case, run.lane_set.lanes.lane_count
    else:
        plan = read_plan(folder)
        case, count = plan.case, plan.lane_count
    if not 0 <= lane < count:
        raise InputError("--lane", "", lane, f"must be a lane from 0 to {count - 1}")
    pictures = int(max(case.durations) / interval)
    if pictures > MOST_FRAMES:
        allowed = f"must make at most {MOST_FRAMES:,} pictures: a higher --speed or a lower --rate"
        raise InputError("--rate", "", Said(f"{pictures:,} pictures"), allowed)
    if ran:
        return scene_motion(run, lane, interval)
    return scene_motion(run_of_lane(plan, lane), 0, interval)


def _write(path: pathlib.Path, motion: SceneMotion, rate: int) -> None:
    """Writes a lane in the form that the ending of the file says."""
    from warprock.figures.moving import frames
    from warprock.scenes.gltf import write_gltf
    from warprock.scenes.pictures import WRITERS, write_png
    from warprock.scenes.viewers import write_usd

    form = path.suffix.lower()
    if form in WRITERS:
        WRITERS[form](path, frames(motion), float(rate))
    elif form == ".png":
        write_png(path, next(frames(motion, [motion.largest])))
    elif form == ".glb":
        write_gltf(path, motion)
    else:
        write_usd(path, motion, float(rate))


@click.command()
@_FOLDER
@_LANE
@click.option(
    "--viewer",
    type=click.Choice(["viser", "rerun", "window"]),
    default="viser",
    show_default=True,
    help="viser: in the browser; rerun: in the browser, with a time line; window: on a display.",
)
@click.option("--port", type=click.IntRange(1, 65535), default=8080, help="Port for the browser.")
@_SPEED
def view(folder: pathlib.Path, lane: int, viewer: str, port: int, speed: float) -> None:
    """Show a lane of the run or sweep in DIR in one of Newton's viewers, until Ctrl-C.

    It plays over and over. Each viewer needs an extra of its name: viser, rerun or window. For a
    USD file: warprock animate.
    """
    from warprock.scenes.needs import require_package
    from warprock.scenes.viewers import open_viewer, play

    require_package("--viewer", viewer)
    motion = _motion(folder, lane, speed / 30.0)
    opened = open_viewer(viewer, port)
    click.echo(f"{motion.name}: Ctrl-C ends it", err=True)
    play(opened, motion, speed)


COMMANDS = (animate, view)
