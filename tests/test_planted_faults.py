"""Planted faults are found by their definition and tokens, wherever these are; `faults/plant.py` plants them."""

import pathlib
import sys
from types import SimpleNamespace

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent / "faults"))

import generated  # noqa: E402
from definitions import Source  # noqa: E402
from layer import ORDER, Fault, Layer, LostPlace  # noqa: E402

_C = r"""
#include <math.h>
#define MARGIN(x) \
  (1e-6f * (x))
enum { LIMIT = 4, MOST };
typedef struct Pair {
  int a; /* { */
} Pair;
static const double table[] = {1.5, 2.5};
namespace chain {
class Mover : public Base {
public:
    explicit Mover(std::vector<int> list = {}) : size{1}, links(move(list)) {
    }
    bool operator<(const Mover& other) const { return size < other.size; }
private:
    std::function<void(int)> visit;
};
}
template <class T>
static inline T chain::Mover::sum(const T* values, int count) {
    T sum = 0;
    for (int i = 0; i < count && values[i] >= 0.5; i++) sum += values[i]; // "
    notify(sum);
    return !isnan(sum) ? sum : 0;
}
void CT_WIDE(testAll)(Pair* pair) {
  pair->a++;
}
"""

_PYTHON = '''
WORDS = ("one",
         "two")


class Reader:
    """A class."""

    @property
    def first(self):
        for word in WORDS:
            if not word and len(word) < 2:  # a comment
                self.close()
            return "#" + word
'''


def sourceOf(folder: pathlib.Path, name: str, text: str) -> Source:
    path = folder / name
    path.write_text(text)
    return Source(path)


def layerOf(*sources: Source) -> SimpleNamespace:
    return SimpleNamespace(sources=sources, ownSources=sources)


def test_definitions_of_c_are_found_by_name(tmp_path):
    source = sourceOf(tmp_path, "mover.cpp", _C)
    found = {definition.name: source.text[definition.begin : definition.end] for definition in source.definitions}
    assert {name for name in found if "(" in found[name] and "{" in found[name]} >= {
        "Mover", "Mover::Mover", "Mover::operator<", "chain::Mover::sum", "testAll"
    }  # fmt: skip
    assert found["MARGIN"] == "#define MARGIN(x) \\\n  (1e-6f * (x))"
    assert found["LIMIT"].startswith("LIMIT = 4") and found["MOST"] == "MOST"
    assert found["table"].endswith("2.5};") and found["Pair"].endswith("} Pair;") and found["Pair::a"] == "int a;"
    assert found["Mover::visit"] == "std::function<void(int)> visit;"
    assert found["chain::Mover::sum"].startswith("template <class T>") and found["testAll"].endswith("pair->a++;\n}")
    assert {definition.name for definition in source.definitions if definition.isFunction} == {
        "Mover::Mover", "Mover::operator<", "chain::Mover::sum", "testAll"
    }  # fmt: skip


def test_definitions_of_python_are_found_by_name(tmp_path):
    source = sourceOf(tmp_path, "reader.py", _PYTHON)
    found = {definition.name: source.text[definition.begin : definition.end] for definition in source.definitions}
    assert set(found) == {"WORDS", "Reader", "Reader.first"}
    assert found["WORDS"].endswith('"two")\n') and found["Reader.first"].lstrip().startswith("@property")


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text,
        lambda text: text.replace("i < count && values[i] >= 0.5", "i<count/* all */\n&&  values[ i ] // so\n>= 0.5"),
        lambda text: "void other() { int i = 0, count = 1; use(i < count && values[i]); }" + text,
    ],
)
def test_format_comments_and_files_do_not_matter(tmp_path, change):
    sources = [sourceOf(tmp_path, "other.cpp", "int other;"), sourceOf(tmp_path, "new.cpp", change(_C))]
    fault = Fault("sum: one more", "chain::Mover::sum", "i < count && values[i]", "i <= count && values[i]")
    edited = fault.findIn(layerOf(*sources)).edited()
    assert "i <= count && values[i]" in edited and edited.count("<=") == 1


def test_tokens_have_to_be_in_one_place(tmp_path):
    source = sourceOf(tmp_path, "mover.cpp", _C)
    again = sourceOf(tmp_path, "again.cpp", _C)
    fault = Fault("pair: none", "testAll", "pair->a++;", ";")
    assert fault.findIn(layerOf(source)).after == ";"
    with pytest.raises(LostPlace, match="2 times in testAll"):
        fault.findIn(layerOf(source, again))
    assert Fault("pair: none", "testAll", "pair->a++;", ";", "again.cpp").findIn(layerOf(source, again)).source is again
    assert Fault("pair: none", "", "#include <math.h>", "", "again.cpp").findIn(layerOf(source, again)).source is again
    for definition, before in (("testAll", "pair->a--;"), ("testOther", "pair->a++;"), ("testAll", "a+")):
        with pytest.raises(LostPlace, match="0 times"):
            Fault("pair: none", definition, before, ";").findIn(layerOf(source))


def test_lines_of_python_are_indented(tmp_path):
    source = sourceOf(tmp_path, "reader.py", _PYTHON)
    fault = Fault("reader: closes twice", "Reader.first", "self.close()", "self.close()\nself.close()")
    assert fault.findIn(layerOf(source)).edited() == _PYTHON.replace(
        "self.close()\n", "self.close()\n" + 16 * " " + "self.close()\n"
    )


def test_faults_are_generated(tmp_path):
    source = sourceOf(tmp_path, "mover.cpp", _C)
    edits = generated.draw(layerOf(source), 20, 1)
    assert {edit.title.split(": ", 1)[1] for edit in edits} == {
        "< -> <=", ">= -> <", "&& -> ||", "0.5 -> 0", "! ->", "notify(sum); -> ;"
    }  # fmt: skip
    assert all(len(edit.edited().splitlines()) == len(_C.splitlines()) for edit in edits)
    drawn = generated.draw(layerOf(source), 3, 5)
    assert len(drawn) == 3 and drawn == generated.draw(layerOf(source), 3, 5)


def test_faults_are_generated_in_python(tmp_path):
    edits = generated.draw(layerOf(sourceOf(tmp_path, "reader.py", _PYTHON)), 20, 1)
    assert {edit.title.split(": ", 1)[1] for edit in edits} == {
        "not ->", "and -> or", "< -> <=", "+ -> -", "self.close() -> pass"
    }  # fmt: skip
    for edit in edits:
        compile(edit.edited(), "reader.py", "exec")


def test_lists_can_be_read():
    titles = [fault.title for name in ORDER for fault in Layer(name).faults]
    assert len(titles) == len(set(titles)) > 0
