"""The page of benchmarks has the figures of the results."""

import re

import benchmarkpage
import pytest


@pytest.fixture(scope="module")
def page():
    return benchmarkpage.PAGE.read_text(encoding="utf-8")


def test_thePageHasTheFiguresOfTheResults(page):
    assert benchmarkpage.rewrite(page) == page
    assert len(page.split()) <= 2500


def test_aWrongFigureIsSetRight(page):
    row = re.search(r"^\| ours \| (\S+) \|", page, re.MULTILINE)
    wrong = page[: row.start(1)] + "0.01" + page[row.end(1) :]
    assert benchmarkpage.rewrite(wrong) == page


LACKING = [("| ours |", "| theirs |"), ("**Figure 8, ", "**Figure 9, "), ("| 2cas |", "| 2cat |")]


@pytest.mark.parametrize(("old", "new"), LACKING)
def test_whatTheResultsLackIsAnError(page, old, new):
    assert old in page
    with pytest.raises(benchmarkpage.PageError, match=new.strip("| *")):
        benchmarkpage.rewrite(page.replace(old, new, 1))
