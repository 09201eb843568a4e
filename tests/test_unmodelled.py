"""Words for what is not modelled: errors, `keys`, `explain` and README say what is nearest."""

import json
import pathlib

import pytest

import warprock as wr
from tests.shared.commands import invoke
from warprock.case.keys import KEYS
from warprock.unmodelled import UNMODELLED, unmodelled

README = pathlib.Path(__file__).parents[1] / "README.md"
WORDS = [word for each in UNMODELLED for word in each.words]


@pytest.mark.parametrize(
    ("word", "what"),
    [("tie_rod", "Ties"), ("Anchors", "Ties"), ("hazard", "Hazard"), ("wall", "Neighbours")],
)
def test_keys_and_errors_say_what_is_nearest(word, what):
    (meant,) = [each for each in UNMODELLED if each.what.startswith(what)]
    done = invoke("keys", word)
    assert done.exit_code == 2
    assert meant.what in done.output
    assert meant.nearest in done.output
    for key in (f"block.{word}", f"contact.{word}", f"{word}", f"engines.dem.{word}"):
        with pytest.raises(wr.InputError) as error:
            wr.load_case("free-b0", {key: 1})
        assert f"not modelled: {meant.what}; nearest: {meant.nearest}" in str(error.value)
    with pytest.raises(wr.InputError, match="unknown key") as error:
        wr.Block(**{word: 1})
    assert meant.nearest in str(error.value)


def test_no_key_is_called_unmodelled():
    names = {key.rpartition(".")[2].replace("_", " ") for key in KEYS}
    assert not names & set(WORDS)


def test_a_word_is_listed_once_and_found():
    assert len(WORDS) == len(set(WORDS))
    for each in UNMODELLED:
        for word in each.words:
            assert unmodelled(f"block.{word.replace(' ', '_')}s") is each
    assert unmodelled("block.hight") is None
    assert unmodelled("") is None


def test_explain_and_readme_list_them():
    done = invoke("explain", "free-b0", "--json")
    assert json.loads(done.output)["not_modelled"] == [each.what for each in UNMODELLED]
    text = README.read_text(encoding="utf-8")
    for each in UNMODELLED:
        assert f"- {each.what}.\n" in text
