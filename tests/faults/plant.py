"""Do the tests notice? Plants one fault after another in a copy of the repository and runs tests of its layer on it.

    python tests/faults/plant.py [--list | --check] [--layer LAYER ...] [NAME ...]
    python tests/faults/plant.py --generated 20 --seed 1 --layer engine

A fault is a small edit of a source file, such as one could make by mistake. It is caught if a test of its layer fails,
hangs or crashes. LAYER.toml lists faults: the function (or type, table or macro) that has the fault, and its tokens
before and after. Files, white space and comments do not matter, so only a change of the tokens themselves loses a fault
its place; --check lists such faults and builds nothing. Faults by --generated need no list: a comparison is turned, a
margin is zero, a call is left out. Some of these change nothing that a test could notice, so look at each survivor.

The exit status is 1 if nobody noticed a listed fault, and by --strict if one has lost its place. The copy lies in a
temporary folder, or in the one that --folder names, where a later run finds what is built. A fault takes about half a
minute. Faults in Python need PYTHONPATH to name a built package.
"""

import argparse
import os
import pathlib
import shutil
import sys
import tempfile
import time

import generated
from layer import ORDER, REPOSITORY, Edit, Layer, LostPlace
from layertests import CompiledTests, Copy, PythonTests


class Report:
    def __init__(self) -> None:
        self.caught = 0
        self.unnoticed: list[str] = []
        self.lost: list[str] = []

    def print(self) -> None:
        for heading, titles in (("Nobody noticed", self.unnoticed), ("No place or not compiled", self.lost)):
            if titles:
                print(f"{heading}:", *titles, sep="\n    ")
        print(f"{self.caught} of {self.caught + len(self.unnoticed) + len(self.lost)} faults were caught")


def plant(tests: CompiledTests | PythonTests, edit: Edit, report: Report) -> str:
    """Returns what happened."""
    name = str(edit.source.path.relative_to(REPOSITORY))
    tests.copy.write(name, edit.edited().encode())
    try:
        message = tests.make()
        if message:
            report.lost.append(edit.title)
            return f"does not compile\n{message}"
        catchers = tests.catchers()
    finally:
        tests.copy.write(name, edit.source.text.encode())
    if catchers:
        report.caught += 1
        return ", ".join(catchers)
    report.unnoticed.append(edit.title)
    return "NOBODY NOTICED"


def findAll(layers: list[Layer], names: tuple[str, ...], report: Report) -> list[tuple[Layer, Edit]]:
    found = []
    for layer in layers:
        for fault in layer.faults:
            if fault.title.startswith(names):
                try:
                    found.append((layer, fault.findIn(layer)))
                except LostPlace as error:
                    report.lost.append(f"{fault.title}: {error} ({layer.name})")
    return found


def plantAll(copy: Copy, chosen: list[tuple[Layer, Edit]], report: Report) -> None:
    tests: dict[str, CompiledTests | PythonTests] = {}
    for number, (layer, edit) in enumerate(chosen, 1):
        if layer.name not in tests:
            tests[layer.name] = (PythonTests if layer.isPython else CompiledTests)(copy, layer)
            failed = tests[layer.name].make() or ", ".join(tests[layer.name].catchers())
            if failed:
                sys.exit(f"without any fault: {failed}")
        start = time.monotonic()
        result = plant(tests[layer.name], edit, report)
        print(f"{number:3} {edit.title}\n    {result} ({time.monotonic() - start:.0f} s)", flush=True)


def parseArguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults whose title begins so; all if none is given")
    parser.add_argument("--layer", action="append", choices=ORDER, help="faults of this layer alone; may be repeated")
    parser.add_argument("--list", action="store_true", help="only print titles")
    parser.add_argument("--check", action="store_true", help="only list faults that have lost their place")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if a fault has lost its place")
    parser.add_argument("--all", action="store_true", help="run all quick tests, also after one has failed")
    parser.add_argument("--folder", type=pathlib.Path, help="keep the copy in this folder")
    parser.add_argument("--generated", type=int, metavar="N", help="draw N faults in each layer instead of the listed")
    parser.add_argument("--seed", type=int, default=1, help="of --generated; 1 if it is not given")
    return parser.parse_args()


def main() -> int:
    arguments = parseArguments()
    layers = [Layer(name) for name in ORDER if name in (arguments.layer or ORDER)]
    report = Report()
    if arguments.generated:
        drawn = {layer: generated.draw(layer, arguments.generated, arguments.seed) for layer in layers}
        chosen = [(layer, edit) for layer, edits in drawn.items() for edit in edits]
    else:
        chosen = findAll(layers, tuple(arguments.names) or ("",), report)
    if arguments.list:
        print(*(edit.title for _, edit in chosen), *report.lost, sep="\n")
        return 0
    if arguments.check:
        print(*report.lost, f"{len(chosen)} of {len(chosen) + len(report.lost)} faults can be planted", sep="\n")
        return int(arguments.strict and len(report.lost) > 0)
    for tool in ("cmake", "ninja", "git"):
        if shutil.which(tool) is None:
            sys.exit(f"{tool} was not found")
    os.environ.pop("CHAINTREE_SIMD", None)
    os.environ.pop("CHAINTREE_TRIALS", None)
    with tempfile.TemporaryDirectory() as temporary:
        plantAll(Copy(arguments.folder or pathlib.Path(temporary), arguments.all), chosen, report)
    report.print()
    failed = (report.unnoticed and not arguments.generated) or (report.lost and arguments.strict)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
