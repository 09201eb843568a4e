"""Case files: what is read, what is refused, and in what words."""

import json
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.shared.case_texts import FREE, PULSE, refusal
from warprock.case.case_file import CaseFile
from warprock.case.keys import KEYS, SWEEP_KEYS
from warprock.case.load import load_case
from warprock.case.text import case_names, template_kinds, template_text
from warprock.errors import InputError, did_you_mean
from warprock.model.response import SampleTimes
from warprock.settings.engines import ImpulseSettings
from warprock.units import Dimension, Quantity


def test_the_shipped_cases_are_these_and_load():
    assert case_names() == [
        "cube-tosses",
        "fragility-fema-p695",
        "fragility-five-blocks",
        "free-b0",
        "free-b1-b3",
        "overturning-map",
        "record-ridgecrest",
        "record-sample",
        "risk-statue",
        "rocking-spectrum",
        "sensitivity-b0",
        "single-continuous-sine",
        "single-sine-pulse",
        "single-spatial-sine",
        "sobol-single-block",
        "space-biaxial",
        "space-free",
        "square-drops",
        "stack-collapse",
        "stack-continuous-sine",
        "stack-continuous-sine-ensemble",
        "stack-sine-pulse",
        "stack-sine-pulse-ensemble",
        "stack-spatial-sine",
    ]
    for name in case_names():
        case = load_case(name)
        assert case.name == name
        assert case.file == f"{name}/case.toml"
        assert case.title
        assert case.source_text
        assert json.loads(json.dumps(case.raw)) == case.raw


def test_every_check_of_a_shipped_case_says_why():
    checks = [check for name in case_names() for check in load_case(name).checks]
    assert len(checks) >= 5
    assert all(len(check.because.split()) > 5 for check in checks)


@pytest.mark.parametrize("kind", template_kinds())
def test_a_template_is_a_commented_case_that_loads(kind, write):
    text = template_text(kind)
    assert sum("#" in line for line in text.splitlines()) >= 5
    assert load_case(write(text)).lane_count >= 1


def test_the_kinds_of_templates():
    kinds = [
        "arch",
        "column",
        "corner",
        "dry-stone",
        "ensemble",
        "facade",
        "frame",
        "free",
        "isolator",
        "map",
        "parapet",
        "pulse",
        "record",
        "sample",
        "spatial",
        "spectrum",
        "stack",
        "strap",
        "strip",
        "study",
        "sweep",
        "vault",
        "wall",
    ]
    assert template_kinds() == kinds
    with pytest.raises(
        InputError,
        match=r"KIND: got 'fre', must be one of arch, column, corner, .* mean free\?",
    ):
        template_text("fre")


def test_values_become_si_and_rad(write):
    case = load_case(write(PULSE + '[start]\nrotation = "10 deg"\n'))
    assert case.tables.block.width == 0.5
    assert case.tables.block.depth == 0.2
    assert case.tables.start.rotation == pytest.approx(0.17453292519943295, rel=1e-15)
    motion = case.tables.motion
    assert motion is not None
    assert motion.amplitude == Quantity(0.008, Dimension.LENGTH)
    assert motion.start == 0.0
    assert case.sample_times == SampleTimes(5.0)
    assert (case.shape, case.lane_count, case.labels) == ((), 1, ())


def test_a_friction_angle_is_its_tangent(write):
    case = load_case(write(FREE), ["contact.friction=30 deg"])
    # tan(30 deg) = 1/sqrt(3); a few roundings.
    assert case.tables.contact.friction == pytest.approx(3.0**-0.5, rel=1e-15)


def test_a_case_is_found_by_folder_and_by_file(write, tmp_path):
    file = write(FREE)
    assert load_case(str(tmp_path)).file == str(file)
    assert load_case(file).folder == tmp_path.resolve()
    assert load_case(file).name == tmp_path.name
    other = tmp_path / "wall.toml"
    other.write_text(FREE, encoding="utf-8")
    assert load_case(other).name == "wall"


def test_a_name_that_no_file_system_takes_is_no_case():
    assert str(refusal("x" * 300)).startswith("CASE: got 'xxx")


def test_no_such_case():
    error = refusal("free-b2")
    assert str(error).startswith(
        "CASE: got 'free-b2', must be a shipped case (free-b0, free-b1-b3, "
    )
    assert "did you mean free-b0?" in str(error)


def test_broken_toml_names_its_line(write):
    error = refusal(write('title = "t"\nblock = [\n'))
    assert "must be TOML" in str(error)
    error = refusal(write('title = "t"\nwidth = 8 mm\n'))
    assert "got 'width = 8 mm', must be TOML" in str(error)
    assert "line 2" in str(error)


def test_a_file_that_is_not_text(tmp_path):
    file = tmp_path / "case.toml"
    file.write_bytes(b"\xff\xfe\x00")
    assert "must be a readable UTF-8 file" in str(refusal(file))


# Edit of the text of FREE or PULSE -> key and words of the refusal.
BAD_TEXT = [
    (FREE, 'width = "0.5 m"', "width = 0.5", "block.width", "got 0.5, must be a length with a"),
    (
        FREE,
        'height = "1 m"',
        'height = "-1 m"',
        "block.height",
        "got '-1 m', must be at least 1 mm",
    ),
    (FREE, 'height = "1 m"', 'height = "nan m"', "block.height", "must be a length with a unit"),
    (FREE, 'height = "1 m"', 'height = "2 km"', "block.height", "at least 1 mm and at most 1 km"),
    (FREE, 'height = "1 m"', "", "block.height", "got nothing, must be the full height"),
    (FREE, "height =", "heigth =", "block.heigth", "did you mean height?"),
    (FREE, "[block]", "[blocks]", "blocks", "did you mean block?"),
    (FREE, "friction = 1.0", "friction = nan", "contact.friction", "got nan, must be a number"),
    (FREE, "friction = 1.0", "friction = -0.1", "contact.friction", "at least 0 and at most 100"),
    (
        FREE,
        'depth = "20 cm"',
        'depth = "20 cm"\nfriction = 1',
        "block.friction",
        "contact.friction?",
    ),
    (FREE, 'title = "t"', "title = 3", "title", "got 3, must be text"),
    (FREE, 'source = "s"', "", "source", "got nothing, must be given"),
    (FREE, 'duration = "5 s"', 'duration = "0 s"', "run.duration", "more than 0 s"),
    (
        FREE,
        'duration = "5 s"',
        'duration = "5 s"\nsample_interval = "6 s"',
        "run.sample_interval",
        "got '6 s', must be at most run.duration, 5 s",
    ),
    (PULSE, '"sine"', '"sinus"', "motion.waveform", "must be a waveform: sine, cosine"),
    (PULSE, '"sine"', '"ricker"', "motion.cycles", "must not be given with waveform ricker"),
    (PULSE, '"sine"', '"record"', "motion.control", "must not be given with waveform record"),
    (PULSE, 'amplitude = "8 mm"', "", "motion.amplitude", "got nothing, must be the amplitude of"),
    (PULSE, '"8 mm"', "8", "motion.amplitude", "a velocity with a unit"),
    (PULSE, "cycles = 1", "", "motion.cycles", "got nothing, must be given, or motion.duration"),
    (PULSE, "cycles = 1", 'cycles = 1\nduration = "-1 s"', "motion.duration", "more than 0 s"),
    (
        PULSE,
        "cycles = 1",
        'cycles = 1\nduration = "1 s"',
        "motion.duration",
        "beside motion.cycles",
    ),
    (PULSE, '"3 Hz"', '"0 Hz"', "motion.frequency", "at least 1e-4 Hz"),
]


@pytest.mark.parametrize(("text", "old", "new", "key", "words"), BAD_TEXT)
def test_bad_values_are_named(text, old, new, key, words, write):
    assert old in text
    file = write(text.replace(old, new))
    error = refusal(file)
    assert str(error).startswith(f"{file}: {key}: got ")
    assert words in str(error)


# Lines added to FREE -> key and words of the refusal.
BAD_ADDITIONS = [
    ("[engines.impuls]\n", "engines", "; did you mean impulse?"),
    ("[engines.impulse]\nsubstep = 1\n", "engines.impulse.substep", "did you mean substeps?"),
    ("[engines.impulse]\nsubsteps = -1\n", "engines.impulse.substeps", "from 0 to 10000"),
    (
        '[start]\nrotation = "1 deg"\nrotation_ratio = 0.1\n',
        "start.rotation_ratio",
        "must not be given beside start.rotation",
    ),
    ("[start]\nrotation_ratio = 1\n", "start.rotation_ratio", "less than 1"),
    (
        '[[check]]\nkind = "peek"\n',
        "check[0].kind",
        "got 'peek', must be peaks, housner, boundaries, outcomes or poses",
    ),
    (
        "[[check]]\n",
        "check[0].kind",
        "got nothing, must be peaks, housner, boundaries, outcomes or poses",
    ),
    (
        '[[check]]\nkind = "housner"\nengine = "impulse"\nbecause = "b"\nlimit = 1.0\n',
        "check[0].limit",
        "unknown key",
    ),
    (
        '[[check]]\nkind = "housner"\nengine = "impulse"\nbecause = ""\nlimit_5s = 1.0\n',
        "check[0].because",
        "at least 1 character",
    ),
    (
        '[[check]]\nkind = "housner"\nengine = "bullet"\nbecause = "b"\nlimit_5s = 1.0\n',
        "check[0].engine",
        "must be an engine: housner, impulse",
    ),
    (
        '[[check]]\nkind = "housner"\nengine = "impulse"\nbecause = "b"\nlimit_5s = 1.0\n',
        "run.sample_interval",
        "must be given for check[0]",
    ),
    (
        '[[check]]\nkind = "peaks"\nengine = "housner"\nbecause = "b"\nvalues = [0.1]\n'
        'tolerance = 1e-3\nwhere = { reading = "double-size" }\n',
        "check[0].where.reading",
        "must be a label of the case (none)",
    ),
]


@pytest.mark.parametrize(("lines", "key", "words"), BAD_ADDITIONS)
def test_bad_tables_are_named(lines, key, words, write):
    file = write(FREE + lines)
    error = refusal(file)
    assert str(error).startswith(f"{file}: {key}: got ")
    assert words in str(error)


def test_a_check_on_a_label_value_that_no_lane_has(write):
    check = (
        '[[sweep]]\nlabel.reading = ["a", "b"]\n'
        '[[check]]\nkind = "peaks"\nengine = "housner"\nbecause = "b"\nvalues = [0.1]\n'
        'tolerance = 1e-3\nwhere = { reading = "c" }\n'
    )
    error = refusal(write(FREE + check))
    assert "check[0].where.reading: got 'c', must be a value of the label (a, b)" in str(error)


@pytest.mark.parametrize(
    ("override", "read"),
    [
        ("block.height=5.5 m", lambda case: case.tables.block.height == 5.5),
        ('block.height="5.5 m"', lambda case: case.tables.block.height == 5.5),
        (" contact.friction = 0.7 ", lambda case: case.tables.contact.friction == 0.7),
        (
            "engines.impulse.substeps=200",
            lambda case: case.engine_settings("impulse").substeps == 200,
        ),
        ("title=Another title", lambda case: case.title == "Another title"),
        ("start.rotation_ratio=-0.5", lambda case: case.tables.start.rotation_ratio == -0.5),
        ('sweep=[{ block.height = ["1 m", "2 m"] }]', lambda case: case.shape == (2,)),
    ],
)
def test_overrides(override, read, write):
    case = load_case(write(FREE), [override])
    assert read(case)
    key = override.partition("=")[0].strip()
    assert case.source_of(key) == "-s"
    assert case.source_of("block.depth") == case.file


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("block.height", "-s: got 'block.height', must be KEY=VALUE"),
        ("block.height=", "must be KEY=VALUE"),
        ("=3", "must be KEY=VALUE"),
        ("block.height=5.5", "-s: block.height: got 5.5, must be a length with a unit"),
        ("block.height=-5.5 m", "-s: block.height: got '-5.5 m', must be at least 1 mm and"),
        ("block.heigh=5.5 m", "-s: block.heigh: got '5.5 m', unknown key"),
        ("block.width.x=1", "-s: block.width.x: got '1', must not lie below width"),
        ("block=1", "-s: block: got 1, must be a table"),
        ("engines.impulse.erp=2", "-s: engines.impulse.erp: got 2, must be from 0 to 1"),
        ("sweep=[{block.height=[]}]", "-s: sweep[0].block.height: got [], must be a list"),
        # What a table lacks that the override alone has made.
        ("motion.amplitude=1 g", "-s: motion.waveform: got nothing"),
        ("motion.amplitude=1 g, 2 g", "-s: motion.waveform: got nothing"),
        ("tie.3.height=1 m", "-s: tie.1: got nothing, must be given"),
    ],
)
def test_a_bad_override_is_named_by_its_option(override, words, write):
    assert words in str(refusal(write(FREE), override))


def test_an_override_replaces_the_axis_it_lies_on():
    case = load_case("single-sine-pulse")
    assert case.shape == (3, 6)
    assert load_case("single-sine-pulse", ["motion.frequency=4 Hz"]).shape == (3,)
    assert load_case("single-sine-pulse", ["block.depth=1 m"]).shape == (3, 6)
    assert load_case("single-sine-pulse", ["block.width=0.2 m"]).shape == (6,)


@pytest.mark.parametrize(
    ("override", "values"),
    [
        ("motion.amplitude=0.1 m to 0.3 m, 3", [0.1, 0.2, 0.3]),
        ("motion.amplitude=1 mm to 100 mm,3 log", [0.001, 0.01, 0.1]),
        ("motion.amplitude=1 m, 2 m", [1.0, 2.0]),
        ('motion.amplitude=["1 m", "2 m"]', [1.0, 2.0]),
        ('motion.amplitude={ from = "1 m", to = "2 m", count = 2 }', [1.0, 2.0]),
    ],
)
def test_an_override_may_sweep_its_key(override: str, values: list[float]):
    case = load_case("single-sine-pulse", [override])
    assert case.shape == (3, len(values))
    assert case.axes[-1].columns["motion.amplitude"].values == pytest.approx(values)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        (
            "motion.amplitude=1 m to 2 m",
            "-s: motion.amplitude: got '1 m to 2 m', must say how many",
        ),
        ("motion.amplitude=1 m, 2 kg", "-s: sweep[1].motion.amplitude[1]: got '2 kg', must be"),
        ("motion.amplitude=0 m to 1 m, 3 log", "-s: sweep[1].motion.amplitude.from: got '0 m'"),
        ("run.sample_interval=1 s, 2 s", "-s: run.sample_interval: got '1 s, 2 s', must be a time"),
    ],
)
def test_a_bad_sweep_is_named_by_its_option(override: str, words: str):
    with pytest.raises(InputError, match=f"^{re.escape(words)}"):
        load_case("single-sine-pulse", [override])


def test_an_override_replaces_the_other_way_of_saying_it():
    case = load_case("free-b1-b3", ["start.rotation=2 deg"])
    assert case.shape == (3,)
    assert case.tables.start.rotation_ratio is None
    case = load_case("single-sine-pulse", ["motion.duration=1 s"])
    assert case.tables.motion is not None
    assert case.tables.motion.cycles is None


def test_engine_settings_of_a_case_and_defaults(write):
    case = load_case(write(FREE + "[engines.impulse]\niterations = 7\n"))
    assert case.engine_settings("impulse") == ImpulseSettings(iterations=7)
    with pytest.raises(InputError, match=re.escape("must be one of housner, impulse")):
        case.engine_settings("bullet")


def test_the_table_of_keys_and_the_models_are_the_same_keys():
    from warprock.case.assembly import Assembly
    from warprock.case.block import Block, StackedBlock
    from warprock.case.body import Body, StackedBody
    from warprock.case.hold import Frame, Ground, Strip, Tie, TopLoad, TransverseWall
    from warprock.case.motion import Motion
    from warprock.case.support import Support

    models = {
        f"{table}.{name}"
        for table in ("contact", "start", "run")
        for name in CaseFile.model_fields[table].annotation.model_fields
    }
    models |= {f"motion.{name}" for name in Motion.model_fields if name not in "yz"}
    models |= {f"transverse_wall.{name}" for name in TransverseWall.model_fields}
    given_whole = {"fixed", "openings", "weak_joints"}
    models |= {f"assembly.{name}" for name in Assembly.model_fields if name not in given_whole}
    models |= {f"support.{name}" for name in Support.model_fields}
    models |= {f"frame.{name}" for name in Frame.model_fields}
    models |= {f"strip.{name}" for name in Strip.model_fields}
    models |= {f"ground.{name}" for name in Ground.model_fields}
    models |= {f"top_load.{name}" for name in TopLoad.model_fields}
    models |= {f"tie.N.{name}" for name in Tie.model_fields}
    lists = {"base", "centre", "inertia", "top"}
    models |= {f"block.{name}" for name in Body.model_fields if name not in lists}
    models |= {f"block.N.{name}" for name in StackedBody.model_fields if name not in lists}
    models |= {f"block.{name}" for name in Block.model_fields}
    models |= {f"block.N.{name}" for name in StackedBlock.model_fields}
    assert set(KEYS) == models | {"model"}
    assert set(KEYS) - set(SWEEP_KEYS) == {
        "model",
        "assembly.first_course",
        "assembly.joint_tolerance",
        "assembly.pattern",
        "motion.sa_period",
        "run.sample_interval",
    }


def test_suggestions_go_by_the_last_part_of_a_key():
    assert did_you_mean("block.friction", KEYS) == "; did you mean contact.friction?"
    assert did_you_mean("zzz", KEYS) == ""


JUNK = st.one_of(
    st.text(max_size=12),
    st.sampled_from(
        [
            "nan",
            "inf",
            "-1",
            "0",
            "[]",
            "{}",
            "true",
            "1979-05-27",
            "[[1]]",
            "8 mm",
            "{a = 1}",
            "-3 Hz",
        ]
    ),
    st.floats().map(repr),
)
PARTS = sorted(
    {part for key in KEYS for part in key.split(".")} | {"sweep", "check", "engines", "x"}
)


@pytest.mark.thorough
@settings(max_examples=40)
@given(path=st.lists(st.sampled_from(PARTS), min_size=1, max_size=3), value=JUNK)
def test_whatever_is_written_the_answer_is_a_case_or_one_line(path, value):
    said = ""
    try:
        case = load_case("single-sine-pulse", [f"{'.'.join(path)}={value}"])
        assert case.lane_count >= 1
        json.dumps(case.raw, allow_nan=False)
    except InputError as error:
        said = str(error)
    assert "\n" not in said
