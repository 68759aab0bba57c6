"""Links of pages to files outside docs, which lead to pages of the site or become text; and code blocks of programs.

Pages are also read in the repository, where ../CONTRIBUTING.md is a file; on the site it is a page.
"""

import re
from pathlib import PurePosixPath

from docutils import nodes

# The pages for files and folders of the repository.
PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "CITATION.cff": "citing.md",
    "examples": "examples.md",
    "examples/engine": "c.md",
    "examples/own_monte_carlo.py": "own-monte-carlo.md",
    "examples/sample_protein.py": "sampling.md",
    "examples/validate_trajectory.py": "validating.md",
    "examples/watch_clashes.py": "validating.md",
    "platforms/reference/chaintree/include/chaintree.h": "c.md",
    "platforms/reference/energy/include/ctenergy.h": "c.md",
    "platforms/reference/moves/include/ctclosure.h": "c.md",
    "platforms/reference/moves/include/ctdensity.h": "c.md",
    "platforms/reference/moves/include/ctgrowth.h": "c.md",
    "platforms/reference/moves/include/ctlocal.h": "c.md",
}
_LINK = re.compile(r"(?<!!)\[([^][]*)\]\((?!https?:|#|mailto:)([^()#\s]*)(#[^()\s]*)?\)")
_PICTURE = re.compile(r"(!\[[^][]*\]\()docs/")


def setup(app):
    app.connect("source-read", _onSourceRead)
    app.connect("include-read", _onIncludeRead)
    app.connect("doctree-read", _endPieces)
    return {"parallel_read_safe": True}


def _onSourceRead(app, name, source):
    source[0] = _LINK.sub(_pageLink, source[0])


def _onIncludeRead(app, path, parent, source):
    """Replace links in included files of the top folder, such as README.md, whose paths to pages begin with docs."""
    if path.suffix == ".md" and path.parent.as_posix() == "..":
        source[0] = _PICTURE.sub(r"\1", _LINK.sub(lambda match: _pageLink(match, "."), source[0]))


def _endPieces(app, doctree):
    """Remove empty lines at the end of code blocks, which pieces of programs have."""
    for block in doctree.findall(nodes.literal_block):
        if block.rawsource == block.astext():  # otherwise it is highlighted already
            block.rawsource = block.rawsource.rstrip()
            block[:] = [nodes.Text(block.rawsource)]


def _pageLink(match, folder="docs"):
    """Return the replacement for a link in a file of a folder of the repository."""
    text, target, anchor = match.group(1), match.group(2), match.group(3) or ""
    path = _normal(PurePosixPath(folder) / target) if target else folder
    isPath = text != "" and path.endswith(text)
    if not target:
        return match[0]
    if path.startswith("docs/"):
        return f"[{PurePosixPath(path).stem.capitalize() if isPath else text}]({path.removeprefix('docs/')}{anchor})"
    if isPath:
        text = f"`{text}`"
    if path in PAGES:
        return f"[{text}]({PAGES[path]}{anchor})"
    return text if isPath or "`" in text else f"{text} (`{path}`)"


def _normal(path):
    parts = []
    for part in path.parts:
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)
