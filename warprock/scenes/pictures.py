"""Pictures of a lane as files: GIF and PNG through Pillow, MP4 through ffmpeg."""

from __future__ import annotations

import itertools
import pathlib
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from warprock.running.files import replacing

Frame = npt.NDArray[np.uint8]

GIF_COLOURS = 64


def write_gif(path: pathlib.Path, frames: Iterator[Frame], rate: float) -> None:
    """Writes a GIF that repeats for ever.

    Args:
        path: The file.
        frames: Its pictures.
        rate: Pictures a second; GIF counts in hundredths of a second.
    """
    from PIL import Image

    first = Image.fromarray(next(frames)).quantize(GIF_COLOURS)
    plain = Image.Dither.NONE
    rest = (Image.fromarray(frame).quantize(palette=first, dither=plain) for frame in frames)
    with replacing(path) as temporary:
        first.save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=rest,
            duration=max(20, round(100.0 / rate) * 10),
            loop=0,
        )


def write_png(path: pathlib.Path, frame: Frame) -> None:
    """Writes one picture as a PNG.

    Args:
        path: The file.
        frame: The picture.
    """
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(frame).save(temporary, format="PNG")


def write_mp4(path: pathlib.Path, frames: Iterator[Frame], rate: float) -> None:
    """Writes an MP4 (H.264) that players and slides show.

    Args:
        path: The file.
        frames: Its pictures, of even width and height.
        rate: Pictures a second.
    """
    import imageio_ffmpeg

    first = next(frames)
    with replacing(path) as temporary:
        writer = imageio_ffmpeg.write_frames(
            str(temporary),
            (first.shape[1], first.shape[0]),
            fps=rate,
            quality=7,
            macro_block_size=2,
            output_params=["-f", "mp4", "-movflags", "+faststart"],
        )
        writer.send(None)
        for frame in itertools.chain([first], frames):
            writer.send(np.ascontiguousarray(frame))
        writer.close()


WRITERS: dict[str, Callable[[pathlib.Path, Iterator[Frame], float], None]] = {
    ".gif": write_gif,
    ".mp4": write_mp4,
}
"""What writes a picture, by the ending of its file."""
