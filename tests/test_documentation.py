"""The site builds without warnings, and its internal links have targets."""

import ast
import html
import re
import shutil
import subprocess
import sys
import threading
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import quote, unquote, urlsplit

import openmmchaintree
import pytest
from openmmchaintree.command import cli

PROJECT = Path(__file__).parents[1]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# Of the group docs of pyproject.toml.
MODULES = ("sphinx", "myst_parser", "breathe", "furo", "sphinx_argparse_cli", "sphinx_copybutton", "latex2mathml")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site."""
    for module in MODULES:
        pytest.importorskip(module, reason="the group docs of pyproject.toml is not installed")
    if shutil.which("doxygen") is None:
        pytest.skip("doxygen is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-d", str(folder / "doctrees")]
    result = subprocess.run([*command, str(PROJECT / "docs"), str(folder / "html")], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return folder / "html"


class Page(HTMLParser):
    """The links of a page, and the names to which pages can link."""

    def __init__(self, path):
        super().__init__()
        self.links, self.names = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            elif name == "id":
                self.names.add(value)


def test_everyLinkWithinTheSiteLeadsSomewhere(site):
    pages = {path: Page(path) for path in site.rglob("*.html")}
    assert len(pages) > 15
    lost, count = [], 0
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            names = pages[target].names if target in pages else set()
            count += 1
            if not target.exists() or (parts.fragment and unquote(parts.fragment) not in names | {"top"}):
                lost.append(f"{path.relative_to(site)}: {link}")
    assert not lost and count > 1000


def test_nothingIsTakenFromOtherSites(site):
    """Pages load nothing from other sites."""
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        taken = re.findall(r'<(?:script|img|iframe)[^>]*\ssrc="(https?:[^"]*)"', text)
        taken += re.findall(r'<link[^>]*rel="(?:stylesheet|preload)"[^>]*href="(https?:[^"]*)"', text)
        assert not taken, path


@pytest.fixture(scope="module")
def address(site):
    """The address at which the site is served."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *arguments):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=site)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.mark.parametrize(
    ("words", "page"),
    [
        ("Born radii", "energies.html"),
        ("--add-hydrogens", "command.html#openmm-chaintree-sample---add-hydrogens"),
        ("addClosedMove", "python-integrator.html#openmmchaintree.TorsionMonteCarloIntegrator.addClosedMove"),
    ],
)
def test_aBrowserFindsWhatOneSearches(address, tmp_path, words, page):
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip(f"none of the browsers {', '.join(BROWSERS)} is installed")
    options = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path}",
        "--virtual-time-budget=9000",
    ]
    command = [browser, *options, "--dump-dom", f"{address}/search.html?q={quote(words)}"]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=120).stdout
    assert "Search finished, found" in shown
    results = shown[shown.index('id="search-results"') :]
    assert f'href="{page}"' in results


def test_everyPublicNameIsThere(site):
    names = set().union(*(Page(path).names for path in site.glob("python*.html")))
    missing = [name for name in openmmchaintree.__all__ if f"openmmchaintree.{name}" not in names]
    for owner in ("StericExclusionForce", "TorsionMonteCarloIntegrator", "TorsionDensity"):
        members = (name for name in vars(getattr(openmmchaintree, owner)) if name[0] != "_" and name != "thisown")
        missing += [name for member in members if (name := f"openmmchaintree.{owner}.{member}") not in names]
    assert not missing


@pytest.mark.parametrize("command", cli._COMMANDS)
def test_thePageOfTheCommandHasEveryOptionOfItsHelp(site, command):
    call = [sys.executable, "-m", "openmmchaintree", command, "--help"]
    shown = subprocess.run(call, capture_output=True, text=True, check=True).stdout
    options, _, examples = shown.partition("In a force field, with implicit solvent:")
    named = set(re.findall(r"^  (?:-\w(?: \w+)?, )?(--[\w-]+)", options, re.MULTILINE))
    assert len(named) > 10
    page = site / "command.html"
    assert {f"openmm-chaintree-{command}-{option}" for option in named} <= Page(page).names
    text = html.unescape(re.sub(r"<[^>]+>", "", page.read_text(encoding="utf-8")))
    assert " ".join(examples.split()) in " ".join(text.split())


def test_formulasAreTypeset(site):
    for name in ("theory", "moves", "energies"):
        text = (site / f"{name}.html").read_text(encoding="utf-8")
        formulas = re.findall(r"<math.*?</math>", text, re.DOTALL)
        assert len(formulas) > 20
        rest = re.sub(r"<(math|code|pre|script).*?</\1>", "", text, flags=re.DOTALL)
        assert "$" not in rest and not re.search(r"\\[a-zA-Z]|exp\(", rest)


def test_resultsStandUnderReturns(site):
    """SWIG lists results among the parameters; aliases keep their names of the source."""
    text = re.sub(r"<[^>]+>", "", (site / "python-force.html").read_text(encoding="utf-8"))
    text = re.sub(r"\s+", " ", html.unescape(text))
    clashes = text[text.index("getClashes(context") :]
    assert re.match(r"getClashes\(context: openmm\.Context\) → tuple\[Ints, Floats\]", clashes)
    parameters, returns = clashes.index("Parameters"), clashes.index("Returns")
    assert parameters < clashes.index("context", parameters) < returns < clashes.index("overlaps", returns)
    assert "pairs" not in clashes[parameters:returns]
    assert "NDArray[np." not in text


def describeMoves():
    """Return the table of moves and their parameters: as the library declares them, with the defaults of the stub."""
    integrator = openmmchaintree.TorsionMonteCarloIntegrator
    stub = ast.parse(Path(openmmchaintree.__file__).with_name("openmmchaintree.pyi").read_text(encoding="utf-8"))
    methods = {node.name: node.args for node in ast.walk(stub) if isinstance(node, ast.FunctionDef)}
    moves = {}
    for line in integrator._listMoveParameters().splitlines():
        move, *parameter = line.split("\t")
        moves.setdefault(move, []).append(parameter)
    table = ["| move | parameter | meaning | unit | values | default |", "|---|---|---|---|---|---|"]
    for move in sorted(moves, key=lambda name: getattr(integrator, name)):
        arguments = methods[f"add{move}"]
        names = [argument.arg for argument in arguments.args]
        assert names[:2] == ["self", "weight"] and len(names) == 2 + len(moves[move])
        defaults = [None] * (len(names) - len(arguments.defaults)) + [ast.unparse(one) for one in arguments.defaults]
        first = f"`add{move}`"
        for name, default, (declared, text, unit, values) in zip(names[2:], defaults[2:], moves[move], strict=True):
            assert declared in (name, "densities")  # which Python calls density
            isChoice = default == "None" and declared != "densities"
            meaning, default = ("which to choose from", text) if isChoice else (text, default or "")
            unit = "" if unit == "1" else unit
            table.append(f"| {first} | `{name}` | {meaning} | {unit} | {values} | {default} |")
            first = ""
    return "\n".join(re.sub(r" +\|", " |", line) for line in table)


def test_theTableOfMovesIsThatOfTheLibrary():
    table = describeMoves()
    assert table in (PROJECT / "docs" / "moves.md").read_text(encoding="utf-8"), table
