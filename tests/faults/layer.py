"""Layers of the repository, and the faults that are listed for each in LAYER.toml."""

import functools
import pathlib
import sys
from dataclasses import dataclass

from definitions import Source, isPython, tokensOf

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent.parent
ORDER = ("engine", "energy", "moves", "api", "python")


class LostPlace(Exception):
    """A fault has no place, or several."""


@dataclass(frozen=True)
class Edit:
    """A fault at its place: characters of a file, and the text that replaces them."""

    title: str
    source: Source
    begin: int
    end: int
    after: str

    def edited(self) -> str:
        text = self.source.text
        line = text[text.rfind("\n", 0, self.begin) + 1 : self.begin]
        indent = " " * (len(line) - len(line.lstrip(" ")))
        return text[: self.begin] + self.after.replace("\n", "\n" + indent) + text[self.end :]


@dataclass(frozen=True)
class Fault:
    """A fault as it is listed: in which definition which tokens become others."""

    title: str
    definition: str
    before: str
    after: str
    file: str = ""  # with any path; needed where files have definitions of the same name, or none is around the tokens

    def findIn(self, layer: "Layer") -> Edit:
        sources = [source for source in layer.sources if not self.file or source.path.name == self.file]
        places = {(source, *place) for source in sources for place in self._placesIn(source)}
        if len(places) != 1:
            raise LostPlace(f"its tokens are {len(places)} times in {self.definition or self.file}")
        return Edit(self.title, *places.pop(), self.after)

    def _placesIn(self, source: Source) -> list[tuple[int, int]]:
        tokens = [token.text for token in tokensOf(self.before, isPython(source.path.name))]
        if not self.definition:
            return source.find(tokens, 0, len(source.text))
        found = [definition for definition in source.definitions if definition.name == self.definition]
        return [place for definition in found for place in source.find(tokens, definition.begin, definition.end)]


class Layer:
    """Sources in which faults are planted, and the tests that shall catch them."""

    def __init__(self, name: str):
        self.name = name
        content = tomllib.loads((pathlib.Path(__file__).parent / f"{name}.toml").read_text())
        settings = content.pop("layer")
        self.folders: list[str] = settings["folders"]  # in which faults are generated
        self.shared: list[str] = settings["shared"]  # further folders in which listed faults may lie
        self.slow: str = settings["slow"]  # tests that run one by one if the others have not caught a fault
        self.never: str = settings["never"]  # tests that do not run
        self.isPython = name == "python"
        self.faults = [
            Fault(title, fault.get("in", ""), fault["before"], fault["after"], fault.get("file", ""))
            for title, fault in content.items()
        ]

    @functools.cached_property
    def sources(self) -> list[Source]:
        paths = [path for folder in (*self.folders, *self.shared) for path in self._files(folder)]
        return [Source(path) for path in dict.fromkeys(paths)]

    @property
    def ownSources(self) -> list[Source]:
        folders = [REPOSITORY / folder for folder in self.folders]
        return [source for source in self.sources if any(source.path.is_relative_to(folder) for folder in folders)]

    def _files(self, folder: str) -> list[pathlib.Path]:
        suffixes = (".py",) if self.isPython else (".c", ".cpp", ".h")
        files = (REPOSITORY / folder).rglob("*")
        return sorted(
            path for path in files if path.suffix in suffixes and "tests" not in path.relative_to(REPOSITORY).parts
        )
