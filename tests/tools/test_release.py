"""A release is made in a clone; versions come from tags."""

from __future__ import annotations

import datetime
import pathlib
import re
import shutil

import pytest
import setuptools_scm

from tools import release

DAY = datetime.date(2026, 12, 1)


@pytest.fixture
def source(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    """A repository with the files that a release changes."""
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "a")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "a@b.c")
    for name in ("CHANGELOG.md", "CITATION.cff"):
        shutil.copy(release.ROOT / name, tmp_path)
    text = (tmp_path / "CHANGELOG.md").read_text(encoding="utf-8")
    assert release.MARK in text.split("\n## ")[1].splitlines()[0]
    top = f"# Changes\n\n## 0.3.0{release.MARK}\n\n- New.\n\n## 0.2.0\n\n- Old.\n"
    (tmp_path / "CHANGELOG.md").write_text(top, encoding="utf-8")
    release.git(tmp_path, "init", "--quiet")
    release.git(tmp_path, "add", "--all")
    release.git(tmp_path, "commit", "--quiet", "--message", "first")
    release.git(tmp_path, "tag", "v0.2.0")
    return tmp_path


def test_a_release_is_a_commit_with_a_tag(source: pathlib.Path) -> None:
    assert release.mark(source, "0.3.0", DAY) == "- New."
    text = (source / "CHANGELOG.md").read_text(encoding="utf-8")
    assert text == (
        f"# Changes\n\n## 0.4.0{release.MARK}\n\n## 0.3.0\n\n- New.\n\n## 0.2.0\n\n- Old.\n"
    )
    cited = (source / "CITATION.cff").read_text(encoding="utf-8")
    assert "\nversion: 0.3.0\ndate-released: 2026-12-01\nlicense: Apache-2.0\n" in cited
    assert release.git(source, "describe") == "v0.3.0"
    assert release.git(source, "status", "--porcelain") == ""


def test_the_version_is_read_from_the_tags(source: pathlib.Path) -> None:
    (source / "CHANGELOG.md").write_text(
        f"# Changes\n\n## 0.3.0{release.MARK}\n\n- New.\n", encoding="utf-8"
    )
    release.mark(source, "0.3.0", DAY)
    assert setuptools_scm.get_version(root=source) == "0.3.0"


@pytest.mark.parametrize(
    ("version", "said"),
    [
        ("0.3", "must be three numbers"),
        ("0.2.0", "must be above 0.2.0, which has a tag"),
        ("0.5.0", "its first section must be '## 0.5.0"),
    ],
)
def test_a_version_that_cannot_be_next_is_refused(
    version: str, said: str, source: pathlib.Path
) -> None:
    with pytest.raises(SystemExit, match=said):
        release.mark(source, version, DAY)
    assert release.git(source, "rev-list", "--count", "HEAD") == "1"


def test_the_changelog_of_this_tree_has_notes_for_the_next_release() -> None:
    text = (release.ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    version = text.split("\n## ")[1].split(release.MARK)[0]
    assert release.section(text, version).startswith("- ")


def test_the_page_of_versions_links_to_each_manual() -> None:
    page = release.versions_page(["0.10.0", "0.9.0"])
    assert re.findall(r'href="(.*?)"', page) == ["0.10.0/index.html", "0.9.0/index.html"]
