"""Tables of a case as Python objects: blocks, motions, sweeps and samples.

Each has the keys of its table in a case file, declared there once (`warprock keys` lists them). A
value is judged when the object is made, in the words of a case file; whether values fit together
is judged by the case.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from warprock.api.plain import plain
from warprock.arguments import at_the_door
from warprock.case.assembly import Assembly as AssemblyTable
from warprock.case.block import Block as BlockTable
from warprock.case.block import StackedBlock
from warprock.case.body import Body as BodyTable
from warprock.case.body import StackedBody
from warprock.case.contact import Contact as ContactTable
from warprock.case.hold import Frame as FrameTable
from warprock.case.hold import Ground as GroundTable
from warprock.case.hold import Strip as StripTable
from warprock.case.hold import Tie as TieTable
from warprock.case.hold import TopLoad as TopLoadTable
from warprock.case.hold import TransverseWall as TransverseWallTable
from warprock.case.motion import Motion as MotionTable
from warprock.case.run import Run as RunTable
from warprock.case.start import Start as StartTable
from warprock.case.support import Support as SupportTable
from warprock.case.sweep_file_columns import swept_columns
from warprock.case.validation import KeyedError, Table, refusing, unknown_key
from warprock.quantity import InputKey, Key

if TYPE_CHECKING:
    import pandas as pd

WIDTH = 96
"""Characters of a line in the docstrings that are made here."""


class Part(Mapping[str, Any]):
    """A table of a case: a mapping of its keys to values, as a case file holds them."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._values: dict[str, Any] = plain(values)

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        given = ", ".join(f"{key}={value!r}" for key, value in self._values.items())
        return f"{type(self).__name__}({given})"


class _Declared(Part):
    """A table whose keys are declared in the case room, and whose values are judged at once."""

    _tables: ClassVar[tuple[type[Table], ...]]

    def __init_subclass__(cls) -> None:
        """Gives the class the signature and the arguments that its keys make."""
        empty = inspect.Parameter.empty
        keyword = inspect.Parameter.KEYWORD_ONLY
        names = [*cls._declared(), *cls._inner()]
        parameters = [inspect.Parameter(n, keyword, default=None, annotation=empty) for n in names]
        cls.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        head, mark, example = inspect.cleandoc(cls.__doc__ or "").partition("Example:")
        lines = [_argument(name, key) for name, key in cls._declared().items()]
        lines += [f"    {name}: {text}" for name, text in cls._inner().items()]
        raises = "Raises:\n    InputError: An unknown key, or a value that cannot be used."
        parts = (head.strip(), "Args:\n" + "\n".join(lines), raises, mark + example)
        cls.__doc__ = "\n\n".join(parts)

    def __init__(self, **values: Any) -> None:
        declared, inner = self._declared(), self._inner()
        found: dict[str, Any] = plain(values)
        with refusing(lambda _: type(self).__name__):
            for name, got in found.items():
                if name in inner:
                    continue
                if name not in declared:
                    raise unknown_key(name, got, (*declared, *inner))
                try:
                    declared[name].value(got)
                except ValueError as error:
                    raise KeyedError(name, got, str(error)) from None
        super().__init__(found)

    @classmethod
    def _declared(cls) -> dict[str, Key]:
        """Keys of the table."""
        return {name: key for table in cls._tables for name, key in table.declared().items()}

    @classmethod
    def _inner(cls) -> dict[str, str]:
        """Tables inside the table, and what each is."""
        return {}


def _argument(name: str, key: Key) -> str:
    """A key as a line of `Args:`."""
    unit = "" if key.unit == "-" else f" [{key.unit}]"
    meaning = key.text.removeprefix("the ")
    other = space = ""
    if isinstance(key, InputKey):
        other = f"; instead of {key.instead_of}" * bool(key.instead_of)
        space = "; in space only" * bool(key.needs_space)
    text = f"{name}: {meaning[:1].upper()}{meaning[1:]}{unit}: {key.bounds_text}{other}{space}."
    return textwrap.fill(text, WIDTH, initial_indent="    ", subsequent_indent="        ")


class Block(_Declared):
    """One rigid block: full sizes and density, of a stack also its place.

    A case takes one block, or a list of blocks that stand on one another, the lowest first;
    chamfer, offset, friction, rotation and yaw belong to blocks of a list. Sizes are text with a
    unit. A body that is no box has mass, base, centre and inertia in the place of sizes and
    density, and below another block its top.

    Example:
        >>> import warprock as wr
        >>> wr.Block(width="0.5 m", height="2 m", depth="0.5 m", density="2400 kg/m^3")
        Block(width='0.5 m', height='2 m', depth='0.5 m', density='2400 kg/m^3')
        >>> wr.Block(width=0.5)
        Traceback (most recent call last):
        ...
        warprock.InputError: Block: width: got 0.5, must be a length with a unit (m, cm, mm, km, \
in, ft), such as "8 mm"
    """

    _tables = (StackedBody, StackedBlock, BodyTable, BlockTable)


class Assembly(_Declared):
    """Many blocks with dry joints, laid by a pattern: an arch, a wall, a column or a frame.

    A case has it in the place of a block. Each pattern has keys of its own.

    Example:
        >>> import warprock as wr
        >>> wr.Assembly(pattern="column", drum_width="1 m", drum_height="0.5 m", drums=12,
        ...             density="2400 kg/m^3")["drums"]
        12
    """

    _tables = (AssemblyTable,)


class Contact(_Declared):
    """What happens between blocks and base.

    Example:
        >>> import warprock as wr
        >>> wr.Contact(friction=0.6)
        Contact(friction=0.6)
    """

    _tables = (ContactTable,)


class TransverseWall(_Declared):
    """A wall at one side of a single block: the block can rock to the other side alone.

    Example:
        >>> import warprock as wr
        >>> wr.TransverseWall(side="left", rebound="plastic")
        TransverseWall(side='left', rebound='plastic')
    """

    _tables = (TransverseWallTable,)


class Tie(_Declared):
    """A tie of a single block, horizontal, to a point far away.

    Example:
        >>> import warprock as wr
        >>> wr.Tie(height="4.5 m", side="left", stiffness="2 kN/mm", yield_force="12 kN")["side"]
        'left'
    """

    _tables = (TieTable,)


class TopLoad(_Declared):
    """A load on the top of a single block: forces without inertia.

    Example:
        >>> import warprock as wr
        >>> wr.TopLoad(weight="20 kN", eccentricity="-10 cm")
        TopLoad(weight='20 kN', eccentricity='-10 cm')
    """

    _tables = (TopLoadTable,)


class Frame(_Declared):
    """A frame of equal columns, each the block of the case, capped by a beam.

    Example:
        >>> import warprock as wr
        >>> wr.Frame(columns=4, beam_mass="96 t")
        Frame(columns=4, beam_mass='96 t')
    """

    _tables = (FrameTable,)


class Support(_Declared):
    """A floor of a building or an isolator under the block: a linear oscillator along x.

    Example:
        >>> import warprock as wr
        >>> wr.Support(frequency="2.5 Hz", damping=0.05, height_factor=1.3)["damping"]
        0.05
    """

    _tables = (SupportTable,)


class Strip(_Declared):
    """A strip of wall between two floors: the block, in two pieces with a hinge between them.

    Example:
        >>> import warprock as wr
        >>> wr.Strip(hinge_height=0.5, weight="20 kN")
        Strip(hinge_height=0.5, weight='20 kN')
    """

    _tables = (StripTable,)


class Ground(_Declared):
    """Compliant ground below a single block: springs and dampers that press and do not pull.

    Example:
        >>> import warprock as wr
        >>> wr.Ground(stiffness="50 MN/m^3", damping="200 kN s/m^3")["stiffness"]
        '50 MN/m^3'
    """

    _tables = (GroundTable,)


class Start(_Declared):
    """How a single block is released.

    Example:
        >>> import warprock as wr
        >>> wr.Start(rotation="2 deg")
        Start(rotation='2 deg')
    """

    _tables = (StartTable,)


class Times(_Declared):
    """Length of the run and sampling of its histories, the table [run] of a case file.

    Example:
        >>> import warprock as wr
        >>> wr.Times(duration="5 s", sample_interval="10 ms")
        Times(duration='5 s', sample_interval='10 ms')
    """

    _tables = (RunTable,)


class Motion(_Declared):
    """How the base moves: a waveform under a control, or a record times a scale.

    Along x; in space `y` and `z` move it in the other directions.

    Example:
        >>> import warprock as wr
        >>> wr.Motion(
        ...     waveform="ricker", control="acceleration", frequency="1 Hz", amplitude="0.4 g"
        ... )
        Motion(waveform='ricker', control='acceleration', frequency='1 Hz', amplitude='0.4 g')
        >>> wr.Motion(waveform="record", record="ridgecrest-2019-ccc-090", scale=0.5)["scale"]
        0.5
    """

    _tables = (MotionTable,)

    @classmethod
    def _inner(cls) -> dict[str, str]:
        """Motions in the other directions."""
        return {"y": "A motion across the plane of rocking.", "z": "A motion upwards."}


class Grid(Part):
    """Values from a first to a last one, for a sweep.

    Args:
        first: The first value, as the key wants it.
        last: The last value.
        count: How many values, both ends included.
        spacing: "linear" or "log".

    Example:
        >>> import warprock as wr
        >>> wr.Sweep({"block.height": wr.Grid("1 m", "2 m", 5)})
        Sweep({'block.height': {'from': '1 m', 'to': '2 m', 'count': 5}})
    """

    @at_the_door
    def __init__(self, first: Any, last: Any, count: int, spacing: str | None = None) -> None:
        super().__init__({"from": first, "to": last, "count": count, "spacing": spacing})


class Uniform(Part):
    """A number of which each value between two ends is as likely, for a sample.

    Args:
        low: The least value, as the key wants it.
        high: The greatest value.

    Example:
        >>> import warprock as wr
        >>> dict(wr.Uniform("0.1 m", "0.4 m"))
        {'distribution': 'uniform', 'from': '0.1 m', 'to': '0.4 m'}
    """

    shape: ClassVar[str] = "uniform"

    @at_the_door
    def __init__(self, low: Any, high: Any) -> None:
        super().__init__({"distribution": self.shape, "from": low, "to": high})


class Loguniform(Uniform):
    """A number of whose logarithm each value between two ends is as likely; see `Uniform`.

    Example:
        >>> import warprock as wr
        >>> dict(wr.Loguniform("0.5 Hz", "5 Hz"))
        {'distribution': 'loguniform', 'from': '0.5 Hz', 'to': '5 Hz'}
    """

    shape = "loguniform"


class Lognormal(Part):
    """A number whose logarithm is normal, for a sample.

    Args:
        median: The median before the tails are cut, as the key wants it.
        dispersion: Standard deviation of the logarithm [-].
        low: Where the lower tail is cut; None cuts nothing.
        high: Where the upper tail is cut; None cuts nothing.

    Example:
        >>> import warprock as wr
        >>> dict(wr.Lognormal("0.3 g", 0.5, high="2 g"))
        {'distribution': 'lognormal', 'median': '0.3 g', 'dispersion': 0.5, 'to': '2 g'}
    """

    @at_the_door
    def __init__(self, median: Any, dispersion: float, low: Any = None, high: Any = None) -> None:
        drawn = {"median": median, "dispersion": dispersion, "from": low, "to": high}
        super().__init__({"distribution": "lognormal", **drawn})


class Sweep(Part):
    """One axis of a case: lists of the same length, zipped; several sweeps are crossed.

    Args:
        keys: Values by dotted key, `{"block.height": ["1 m", "2 m"]}`, or a `Grid` of them;
            `label.NAME` names lanes. Or a table, one row a lane, whose columns are keys,
            `block.height`, keys with a unit, `block.height [mm]`, or columns of the lane table in
            any unit, `height_m`, `height_mm`.

    Raises:
        InputError: A column of a table is no key, or has an empty cell.

    Example:
        >>> import pandas as pd
        >>> import warprock as wr
        >>> wr.Sweep({"contact.friction": [0.4, 0.6]})
        Sweep({'contact.friction': [0.4, 0.6]})
        >>> wr.Sweep(pd.DataFrame({"height_m": [1.0, 2.0], "frequency_hz": [1.5, 2.5]}))
        Sweep({'block.height': ['1.0 m', '2.0 m'], 'motion.frequency': ['1.5 Hz', '2.5 Hz']})
    """

    @at_the_door
    def __init__(self, keys: Mapping[str, Any] | pd.DataFrame) -> None:
        super().__init__(keys if isinstance(keys, Mapping) else swept_columns(keys, "table"))

    def __repr__(self) -> str:
        return f"Sweep({self._values!r})"


class Sample(Part):
    """Lanes whose inputs are drawn from distributions, or from lists.

    Args:
        over: What each key is drawn from: `{"block.width": Uniform("0.1 m", "0.4 m")}`.
        lanes: Lanes that each cell of the sweep has.
        seed: Seed of the sample; 1 where it is left out.
        sampling: "sobol" (scrambled Sobol' points) or "lhs" (a Latin hypercube).

    Example:
        >>> import warprock as wr
        >>> wr.Sample({"motion.scale": wr.Lognormal(0.6, 0.5)}, lanes=1000)["lanes"]
        1000
    """

    @at_the_door
    def __init__(
        self,
        over: Mapping[str, Any],
        *,
        lanes: int,
        seed: int | None = None,
        sampling: str | None = None,
    ) -> None:
        super().__init__({"lanes": lanes, "seed": seed, "sampling": sampling, "over": over})


class Ensemble(Part):
    """Every cell of the sweep many times over, its inputs a little off.

    Args:
        members: Lanes in a cell, at least 2.
        spread: Half-width about the value of the cell by key, with a unit or as "5 %" of it.
        time_step: Half-width of the factor on the time step of the engine, such as "10 %".
        seed: Seed of the sample; 1 where it is left out.
        sampling: "sobol" (scrambled Sobol' points) or "lhs" (a Latin hypercube).

    Example:
        >>> import warprock as wr
        >>> wr.Ensemble(200, {"block.width": "0.5 mm", "contact.friction": "5 %"})["members"]
        200
    """

    @at_the_door
    def __init__(
        self,
        members: int,
        spread: Mapping[str, Any] | None = None,
        *,
        time_step: str | None = None,
        seed: int | None = None,
        sampling: str | None = None,
    ) -> None:
        given = {"members": members, "seed": seed, "sampling": sampling, "time_step": time_step}
        super().__init__({**given, "spread": spread})


class Spectrum(Part):
    """Blocks of many sizes, a curve a slenderness, for `spectrum`.

    Args:
        period: 2 pi / p of the blocks, p the frequency parameter [s]: a list or a `Grid`.
        slenderness: Their slenderness angles [angle]: a list or a `Grid`.

    Example:
        >>> import warprock as wr
        >>> wr.Spectrum(wr.Grid("1 s", "8 s", 71), ["10 deg", "15 deg"])["slenderness"]
        ['10 deg', '15 deg']
    """

    @at_the_door
    def __init__(self, period: Any, slenderness: Any) -> None:
        super().__init__({"period": period, "slenderness": slenderness})


class Study(Part):
    """Settings of engines that the lanes are run with, one away from the case's own at a time.

    Args:
        engines: Names of engines.
        vary: Values of each setting, the case's own among them.

    Example:
        >>> import warprock as wr
        >>> wr.Study(["impulse"], {"substeps": [20, 200]})
        Study(engines=['impulse'], vary={'substeps': [20, 200]})
    """

    @at_the_door
    def __init__(self, engines: Any, vary: Mapping[str, Any]) -> None:
        super().__init__({"engines": engines, "vary": vary})
