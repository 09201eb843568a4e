"""Sentences of comparisons of assemblies."""

from __future__ import annotations

from warprock.findings.comparison import judged_by_falls


def test_programs_of_others_do_not_know_what_slides_off():
    names = ("assembly", "dem@time_step=1e-4", "mujoco@impedance=0.99", "bullet")
    rows = [{"engine": name, "outcome": "rocking"} for name in names]
    assert judged_by_falls(rows) == []
    slid = [{"engine": "assembly", "outcome": "slid_off"}, *rows[1:]]
    assert judged_by_falls(slid[:2]) == []
    (sentence,) = judged_by_falls(slid)
    assert sentence.startswith("Only falls count in mujoco@impedance=0.99 and bullet:")
