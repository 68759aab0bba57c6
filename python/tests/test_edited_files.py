"""Structure files with any small edits: they are read, or refused with one line that names the file.

The edits are the same in each run; `pytest --hypothesis-seed=N` and a larger EXAMPLES look further.
"""

import os
import warnings

import gemmi
import hypothesis
import pytest
from hypothesis import strategies as st
from openmmchaintree import InputError, findClashes
from scenes import GLYCINES

EXAMPLES = int(os.environ.get("EXAMPLES", 40))

# What programs and people leave in the place of a word, and what no one wants there.
_WORDS = [
    "",
    "?",
    ".",
    "nan",
    "1e308",
    "-1",
    "0",
    "99999999999",
    "'",
    '"',
    "é",
    "\x00",
    "*****",
    "_",
    "#",
    ";",
    "loop_",
]

_LIGAND = [
    "HETATM    9  C1 AHEM B   1      50.000   0.000   0.000  0.50  0.00           C",
    "HETATM   10  C1 BHEM B   1      50.500   0.000   0.000  0.50  0.00           C",
    "HETATM   11 FE   HEM B   1      52.000   0.000   0.000  1.00  0.00          FE",
    "HETATM   12 NA    NA B   2      70.000   0.000   0.000  1.00  0.00          NA1+",
    "HETATM   13  O   HOH B   3      70.000  10.000   0.000  1.00  0.00           O",
    "CONECT    9   11",
]


def _pdb():
    lines = ["CRYST1   90.000   80.000   70.000  90.00 100.00  90.00 P 1           1"]
    lines += [
        "SEQRES   1 A    2  GLY GLY",
        "LINK         C1 AHEM B   1                FE   HEM B   1     1555   1555  1.5",
    ]
    for number in (1, 2):
        lines += [f"MODEL     {number:4}", *GLYCINES, "TER", *_LIGAND[:-1], "ENDMDL"]
    return "\n".join([*lines, _LIGAND[-1], "END", ""])


def _mmCIF():
    structure = gemmi.read_pdb_string(_pdb())
    structure.setup_entities()
    return structure.make_mmcif_document().as_string()


def _component():
    return """data_HEM
loop_
_chem_comp_atom.comp_id
_chem_comp_atom.atom_id
_chem_comp_atom.type_symbol
_chem_comp_atom.model_Cartn_x
_chem_comp_atom.model_Cartn_y
_chem_comp_atom.model_Cartn_z
HEM C1 C 0.0 0.0 0.0
HEM FE FE 2.0 0.0 0.0
"""


def _cut(text, place, word):
    return text[:place]


def _overwrite(text, place, word):
    return text[:place] + word + text[place + len(word) :]


def _insert(text, place, word):
    return text[:place] + word + text[place:]


def _replaceWord(text, place, word):
    end = min(text.find(separator, place) % (len(text) + 1) for separator in " \n")
    begin = max(text.rfind(separator, 0, place) for separator in " \n") + 1
    return text[:begin] + word + text[end:]


def _dropLine(text, place, word):
    begin, end = text.rfind("\n", 0, place) + 1, text.find("\n", place) % (len(text) + 1)
    return text[:begin] + text[end + 1 :]


def _repeatLine(text, place, word):
    begin, end = text.rfind("\n", 0, place) + 1, text.find("\n", place) % (len(text) + 1)
    return text[: end + 1] + text[begin : end + 1] + text[end + 1 :]


_EDITS = st.lists(
    st.tuples(
        st.sampled_from([_overwrite, _insert, _replaceWord, _dropLine, _repeatLine, _cut]),
        st.integers(0, 10**5),
        st.sampled_from(_WORDS),
    ),
    min_size=1,
    max_size=4,
)


@pytest.mark.parametrize(("ending", "make"), [(".pdb", _pdb), (".cif", _mmCIF), (".cif", _component)])
def test_readOrRefused(tmp_path, ending, make):
    whole, path = make(), tmp_path / f"edited{ending}"

    @hypothesis.settings(
        max_examples=EXAMPLES,
        derandomize=not os.environ.get("EXAMPLES"),
        deadline=None,
        database=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(edits=_EDITS)
    def edited(edits):
        text = whole
        for edit, place, word in edits:
            text = edit(text, place % (len(text) + 1), word)
        path.write_text(text, encoding="utf-8", newline="")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                findClashes(path)
        except InputError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path.write_text(whole)
        findClashes(path)
    edited()
