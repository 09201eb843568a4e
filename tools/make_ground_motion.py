"""Makes a shipped ground motion from a raw CSMIP / CGS Volume 1 accelerogram.

    python tools/make_ground_motion.py RAW --channel 1 --name ridgecrest-2019-ccc-090 \
        --start 20 --stop 90 --output cases/ground-motions

The same raw file and options give the same bytes. Processing:

1. subtract the mean of the quiet seconds before the event;
2. pad with zeros and band-pass with a Butterworth filter, forwards and backwards (acausal);
3. integrate to velocity and displacement, cut out the strong part and taper the displacement d
   there with a smooth window w. The acceleration is then w a + 2 w' v + w'' d: it equals a
   where w = 1, and velocity and displacement start and end at zero;
4. write m/s^2, one sample a line, below a header that says all this.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import pathlib
import re

import numpy as np
import numpy.typing as npt
from scipy import signal

Array = npt.NDArray[np.float64]

STANDARD_GRAVITY = 9.80665  # m/s^2, what a strong-motion network means by g
FIELD_WIDTH, FIELDS_PER_LINE = 9, 8  # Fortran format (8f9.6)


@dataclasses.dataclass(frozen=True)
class Channel:
    """One channel of a raw file.

    Attributes:
        number: Number of the channel in the file.
        azimuth: Direction as the file has it, such as "90 Deg".
        station: Station and place.
        started: Start of the recording.
        rate: Samples a second.
        samples: [g].
    """

    number: int
    azimuth: str
    station: str
    started: str
    rate: float
    samples: Array


def read_channels(text: str) -> list[Channel]:
    """Reads every channel of a CSMIP / CGS Volume 1 file.

    Numbers have a fixed width and no guaranteed blank between them, so they are cut, not split.

    Raises:
        ValueError: A channel has another unit or format, or ends too early.
    """
    lines = text.splitlines()
    found = [
        (at, match)
        for at, line in enumerate(lines)
        if (match := re.match(r"\s*(\d+) Accelerogram points at\s+([\d.]+) pts/sec", line))
    ]
    channels = []
    for at, match in found:
        if "units of g" not in lines[at] or "(8f9.6)" not in lines[at]:
            raise ValueError(f"line {at + 1}: expected units of g in (8f9.6), got {lines[at]!r}")
        count, rate = int(match[1]), float(match[2])
        rows = lines[at + 1 : at + 1 + -(-count // FIELDS_PER_LINE)]
        fields = [
            row[column : column + FIELD_WIDTH]
            for row in rows
            for column in range(0, FIELD_WIDTH * FIELDS_PER_LINE, FIELD_WIDTH)
        ][:count]
        head = _last(lines[:at], r"Chan\s+(\d+):\s+(.*\S)")
        samples = np.array([float(field) for field in fields if field.strip()])
        if len(samples) != count:
            raise ValueError(f"channel {head[1]}: {len(samples)} samples, header says {count}")
        station = _last(lines[:at], r"Station Id\.\s+(\S+)\s+([\d.]+[NS],\s*[\d.]+[EW])")
        started = _last(lines[:at], r"Start time:\s+(.*\S)")
        channels.append(
            Channel(
                number=int(head[1]),
                azimuth=head[2],
                station=f"{station[1]} ({station[2]})",
                started=started[1],
                rate=rate,
                samples=samples,
            )
        )
    return channels


def _last(lines: list[str], pattern: str) -> re.Match[str]:
    for line in reversed(lines):
        if match := re.search(pattern, line):
            return match
    raise ValueError(f"no line of the header matches {pattern!r}")


def _integral(values: Array, interval: float) -> Array:
    """Cumulative trapezoidal integral from zero."""
    steps = 0.5 * interval * (values[1:] + values[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)])


def _window(count: int, interval: float, rise: float, fall: float) -> tuple[Array, Array, Array]:
    """A window with twice differentiable ends, its slope [1/s] and its curvature [1/s^2]."""
    time = interval * np.arange(count)
    window, slope, bend = np.ones(count), np.zeros(count), np.zeros(count)
    for distance, length, sign in ((time, rise, 1.0), (time[-1] - time, fall, -1.0)):
        inside = distance < length
        x = distance[inside] / length
        window[inside] = x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
        slope[inside] = sign * 30.0 * x * x * (1.0 - x) ** 2 / length
        bend[inside] = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / length**2
    return window, slope, bend


def process(channel: Channel, options: argparse.Namespace) -> Array:
    """Acceleration of the strong part [m/s^2]."""
    interval = 1.0 / channel.rate
    quiet = round(options.quiet * channel.rate)
    raw = STANDARD_GRAVITY * (channel.samples - np.mean(channel.samples[:quiet]))
    pad = round(3.0 / options.low * channel.rate)
    sections = signal.butter(
        options.order, [options.low, options.high], "bandpass", fs=channel.rate, output="sos"
    )
    padded = np.concatenate([np.zeros(pad), raw, np.zeros(pad)])
    acceleration = signal.sosfiltfilt(sections, padded)
    velocity = _integral(acceleration, interval)
    displacement = _integral(velocity, interval)
    begin = pad + round(options.start * channel.rate)
    end = pad + round(options.stop * channel.rate) + 1
    part = slice(begin, end)
    window, slope, bend = _window(end - begin, interval, options.rise, options.fall)
    return np.asarray(
        window * acceleration[part] + 2.0 * slope * velocity[part] + bend * displacement[part]
    )


def header(channel: Channel, options: argparse.Namespace, digest: str, motion: Array) -> str:
    """The header of the shipped file."""
    interval = 1.0 / channel.rate
    velocity = _integral(motion, interval)
    displacement = _integral(velocity, interval)
    entries = {
        "name": options.name,
        "unit": "m/s^2",
        "interval": f"{interval:g} s",
        "station": f"{options.network}.{channel.station}, channel {channel.number}, "
        f"{channel.azimuth}",
        "source": options.source,
        "licence": options.licence,
        "raw-sha256": digest,
        "recording-start": channel.started,
        "processing": f"mean of the first {options.quiet:g} s subtracted; acausal Butterworth "
        f"band-pass {options.low:g}-{options.high:g} Hz (order {options.order}, forwards and "
        f"backwards); {options.start:g}-{options.stop:g} s of the recording; displacement "
        f"tapered over {options.rise:g} s and {options.fall:g} s at the ends; "
        f"g = {STANDARD_GRAVITY} m/s^2",
        "peaks": f"{np.max(np.abs(motion)):.4g} m/s^2, {np.max(np.abs(velocity)):.4g} m/s, "
        f"{np.max(np.abs(displacement)):.4g} m",
    }
    return "".join(f"# {key}: {value}\n" for key, value in entries.items())


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("raw", type=pathlib.Path, help="raw Volume 1 file")
    parser.add_argument("--channel", type=int, default=1, help="number of the channel")
    parser.add_argument("--name", required=True, help="name of the record and of its file")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="folder to write to")
    parser.add_argument("--start", type=float, required=True, help="start of the strong part [s]")
    parser.add_argument("--stop", type=float, required=True, help="end of the strong part [s]")
    parser.add_argument("--quiet", type=float, default=20.0, help="quiet seconds at the start")
    parser.add_argument("--low", type=float, default=0.1, help="lower corner [Hz]")
    parser.add_argument("--high", type=float, default=25.0, help="upper corner [Hz]")
    parser.add_argument("--order", type=int, default=4, help="order of the Butterworth filter")
    parser.add_argument("--rise", type=float, default=2.0, help="taper at the start [s]")
    parser.add_argument("--fall", type=float, default=5.0, help="taper at the end [s]")
    parser.add_argument("--network", default="CI", help="network code")
    parser.add_argument("--source", default="", help="where the raw file is from")
    parser.add_argument("--licence", default="", help="licence of the raw file")
    return parser.parse_args()


def main() -> None:
    """Reads, processes and writes one channel."""
    options = _arguments()
    content = options.raw.read_bytes()
    channels = {channel.number: channel for channel in read_channels(content.decode("ascii"))}
    channel = channels[options.channel]
    motion = process(channel, options)
    text = header(channel, options, hashlib.sha256(content).hexdigest(), motion)
    text += "".join(f"{value + 0.0:.8g}\n" for value in motion)  # + 0.0 makes -0 a 0
    target = options.output / f"{options.name}.csv"
    target.write_bytes(text.encode("ascii"))
    print(f"{hashlib.sha256(text.encode('ascii')).hexdigest()}  {target.name}")


if __name__ == "__main__":
    main()
