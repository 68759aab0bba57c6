"""Runs doxygen on the C and C++ headers for breathe."""

import shutil
import subprocess
import sys
from pathlib import Path

from sphinx.errors import ExtensionError

PROJECT = Path(__file__).resolve().parents[2]
REFERENCE = PROJECT / "platforms" / "reference"
API = PROJECT / "openmmapi" / "include" / "openmmchaintree"

CPP_HEADERS = [
    API / f"{name}.h"
    for name in ("LoopGrowth", "StericExclusionForce", "TorsionDensity", "TorsionMonteCarloIntegrator")
]
C_HEADERS = [
    REFERENCE / library / "include" / f"{name}.h"
    for library, name in (
        ("chaintree", "chaintree"),
        ("energy", "ctenergy"),
        ("moves", "ctclosure"),
        ("moves", "ctlocal"),
        ("moves", "ctdensity"),
        ("moves", "ctgrowth"),
    )
]

_SETTINGS = """
INPUT = {inputs}
OUTPUT_DIRECTORY = "{output}"
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
QUIET = YES
WARN_AS_ERROR = FAIL_ON_WARNINGS
WARN_IF_UNDOCUMENTED = NO
ENABLE_PREPROCESSING = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = OPENMM_EXPORT_CHAINTREE= SWIG
EXPAND_AS_DEFINED = CT_OPERATORS CT_ENUMERATOR
EXTRACT_ALL = YES
EXTRACT_PRIVATE = NO
SORT_MEMBER_DOCS = NO
JAVADOC_AUTOBRIEF = NO
EXCLUDE_SYMBOLS = OpenMM
OPTIMIZE_OUTPUT_FOR_C = {plainC}
INPUT_FILTER = "{filter}"
"""


def setup(app):
    app.connect("config-inited", _readHeaders, priority=100)
    return {"parallel_read_safe": True}


def _readHeaders(app, config):
    """Run doxygen on the headers of both languages, and give breathe the location of its output."""
    if shutil.which("doxygen") is None:
        raise ExtensionError("doxygen was not found, which reads the C and C++ headers (Debian: apt install doxygen)")
    folder = Path(app.doctreedir) / "headers"
    _runDoxygen(CPP_HEADERS, folder / "cpp", plainC="NO")
    _runDoxygen(C_HEADERS, folder / "c", plainC="YES")
    config.breathe_projects = {"headers": str(folder / "cpp" / "xml"), "engine": str(folder / "c" / "xml")}
    config.breathe_domain_by_file_pattern = {"*/" + header.name: "c" for header in C_HEADERS}


def _runDoxygen(headers, output, **settings):
    output.mkdir(parents=True, exist_ok=True)
    inputs = " ".join(f'"{header}"' for header in headers)
    publicHeader = f"{sys.executable} {Path(__file__).parent / 'publicheader.py'}"
    text = _SETTINGS.format(inputs=inputs, output=output, filter=publicHeader, **settings)
    result = subprocess.run(["doxygen", "-"], input=text, capture_output=True, text=True)
    if result.returncode != 0:
        raise ExtensionError(f"doxygen: {result.stderr.strip()}")
