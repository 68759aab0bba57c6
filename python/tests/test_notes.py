"""Notes are gathered: one line a kind."""

import warnings

from openmmchaintree.notes import Note, found, warnOf


def test_aLineAKind():
    assert str(Note("gaps", ["here"])) == "gaps (1): here"
    assert str(Note("gaps", "abc")) == "gaps (3): a; b; c"
    assert str(Note("gaps", map(str, range(1234)))) == "gaps (1,234): 0; 1; 2; and 1,231 more"
    assert Note("gaps", "ab").lines() == ["gaps (2):", "  a", "  b"]
    assert str(Note("a sentence")) == "a sentence" and Note("a sentence").lines() == ["a sentence"]
    assert found([Note("nothing", []), Note("gaps", "a")])[0].kind == "gaps"


def test_throughWarnings():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnOf([Note("gaps", "abcd")], stacklevel=1)
    assert caught[0].message.note.items == list("abcd")
    assert str(caught[0].message) == "gaps (4): a; b; c; and 1 more"
    assert caught[0].filename == __file__
