"""Signatures and docstrings of the package as the site shows them.

Signatures are taken from the source, or from the type stub for SWIG's classes: Python itself resolves aliases such as
ArrayLike, and has no types for SWIG's methods. Docstrings of SWIG's classes get the usual sections, with results under
Returns.
"""

import ast
import re
import textwrap
from pathlib import Path

import openmmchaintree
from docutils import nodes
from docutils.statemachine import StringList
from sphinx import addnodes
from sphinx.util.docutils import SphinxDirective

VERSION = openmmchaintree.__version__
_PACKAGE = Path(openmmchaintree.__file__).parent
# Aliases of the stub have a leading underscore, which keeps them out of the module; the site omits it.
_ALIAS = re.compile(r"\b_(?=[A-Z])")
_FIELD = re.compile(r"^:(type|param|rtype|return)(?: (\w+))?: *(.*)$")
_CALL = re.compile(r"(?<![\w`.:~])(?:(\w+)(?:::|\.))?(\w+)\(([^()`]*)\)")
_SECTION = re.compile(r"^(?=\w+\n-+$)", re.MULTILINE)
_INDENTED = re.compile(r"(?<!code-block:: c\+\+\n\n)(?<=\n\n)((?: {4}.*\n|\n)*(?: {4}.*(?:\n|$)))")
_TYPES = {"boolean": "bool", "string": "str", ":py:class:`Context`": "openmm.Context"}


def _definitions(file):
    """Return {name: node} of the functions, classes and methods of a file."""
    found = {}
    for node in ast.parse((_PACKAGE / file).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name] = node
        if isinstance(node, ast.ClassDef):
            methods = (member for member in node.body if isinstance(member, ast.FunctionDef))
            found |= {f"{node.name}.{method.name}": method for method in methods}
    return found


_STUB = _definitions("openmmchaintree.pyi")
_SOURCES = {path.stem: _definitions(path.name) for path in _PACKAGE.glob("*.py")} | {"openmmchaintree": _STUB}


def _aliases():
    """Return {alias: definition} of the type aliases in signatures of public names."""
    found = {}
    for file in [*sorted(_PACKAGE.glob("*.py")), _PACKAGE / "openmmchaintree.pyi"]:
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation) == "TypeAlias":
                found[_written(ast.unparse(node.target))] = _written(ast.unparse(node.value))
    functions = [node for name in openmmchaintree.__all__ for node in _functionsOf(f"openmmchaintree.{name}")]
    signatures = " ".join(_written(f"{ast.unparse(node.args)} {ast.unparse(node.returns)}") for node in functions)
    return {name: text for name, text in sorted(found.items()) if re.search(rf"\b{name}\b", signatures)}


def _functionsOf(name):
    """Return the nodes of a public function, or of the methods of a class."""
    node = _definitionOf(name)
    members = node.body if isinstance(node, ast.ClassDef) else [node]
    return [one for one in members if isinstance(one, ast.FunctionDef) and one.returns]


class _Types(SphinxDirective):
    """A directive that lists the type aliases in signatures with their definitions."""

    def run(self):
        lines = []
        for name, text in _aliases().items():
            lines += [f".. py:type:: {name}", f"   :canonical: {text}", ""]
        container = nodes.container()
        self.state.nested_parse(StringList(lines, source=__file__), self.content_offset, container)
        return container.children


def setup(app):
    app.add_directive("chaintree-types", _Types)
    app.connect("autodoc-process-signature", _processSignature)
    app.connect("autodoc-process-docstring", _processDocstring, priority=100)  # before napoleon
    app.connect("autodoc-skip-member", _skipMember)
    app.connect("doctree-read", _linkNames)
    app.connect("missing-reference", _leaveName)
    app.add_role("chaintree-name", _nameRole)
    return {"parallel_read_safe": True}


def _definitionOf(name):
    """Return the node of a name, such as openmmchaintree.Clash or openmmchaintree.Clash.method, or None.

    Names that the package does not export include their module.
    """
    _, owner, *member = name.split(".")
    module = getattr(getattr(openmmchaintree, owner), "__module__", owner).rpartition(".")[2]
    return _SOURCES.get(module, {}).get(".".join([owner, *member] if module != owner else member))


# ---- Names in single backticks: links to names of this package, otherwise text ----


def _nameRole(role, rawtext, text, lineno, inliner, options=None, content=()):
    environment = inliner.document.settings.env
    return [_reference(environment, text.removeprefix("openmmchaintree."), nodes.literal(rawtext, text))], []


def _reference(environment, target, literal):
    attributes = {
        "refdomain": "py",
        "reftype": "obj",
        "reftarget": target,
        "refdoc": environment.docname,
        "refspecific": True,
        "py:module": "openmmchaintree",
        "py:class": environment.ref_context.get("py:class"),
        "chaintreename": True,
    }
    return addnodes.pending_xref("", literal, **attributes)


def _linkNames(app, doctree):
    """Link code in the text of Markdown pages: a name, or a call with arguments."""
    if app.env.docname in ("c", "cpp", "architecture", "engine"):  # these mean C++ classes
        return
    for literal in list(doctree.findall(nodes.literal)):
        name = re.fullmatch(r"(?:\w+\.)?(\w+)(?:\(.*\))?", literal.astext())
        target = name and _targetOf(name[1])
        if target and not isinstance(literal.parent, nodes.reference | addnodes.pending_xref | nodes.title):
            literal.replace_self(_reference(app.env, target, literal.deepcopy()))


def _targetOf(name):
    """Return the full name for a name on a page, or None."""
    if name in openmmchaintree.__all__:
        return f"openmmchaintree.{name}"
    owners = (owner for owner in ("TorsionMonteCarloIntegrator", "StericExclusionForce") if f"{owner}.{name}" in _STUB)
    return next((f"openmmchaintree.{owner}.{name}" for owner in owners), None)


def _leaveName(app, environment, node, content):
    return content if node.get("chaintreename") else None


# ---- Signatures ----


def _processSignature(app, what, name, object, options, signature, result):
    node = _definitionOf(name)
    if isinstance(node, ast.ClassDef):
        node = _definitionOf(f"{name}.__init__") or _constructorOf(node)
    if node is None:
        return None
    arguments = ast.unparse(node.args)
    if what in ("class", "exception", "method") and not _isStatic(node):
        arguments = re.sub(r"^self(, )?", "", arguments)
    result = ast.unparse(node.returns) if node.returns and what in ("function", "method") else None
    return f"({_written(arguments)})", result and _written(result)


def _constructorOf(node):
    """Return a function with the fields of a named tuple as its parameters, or None for other classes."""
    fields = [member for member in node.body if isinstance(member, ast.AnnAssign)]
    if not any(ast.unparse(base) == "NamedTuple" for base in node.bases):
        return None
    arguments = ast.arguments(
        posonlyargs=[], args=[ast.arg(field.target.id, field.annotation) for field in fields], kwonlyargs=[],
        kw_defaults=[], defaults=[field.value for field in fields if field.value],
    )  # fmt: skip
    return ast.FunctionDef(node.name, arguments, [], [], None)


def _isStatic(node):
    return any(ast.unparse(decorator) == "staticmethod" for decorator in node.decorator_list)


def _written(text):
    return _ALIAS.sub("", text)


def _skipMember(app, what, name, object, skip, options):
    return True if name == "thisown" else None


# ---- Docstrings ----


def _processDocstring(app, what, name, object, options, lines):
    text = "\n".join(lines)
    if what == "attribute":
        lines[:0] = ["..", ""]  # an empty comment; otherwise napoleon takes words before a colon for a type
        return
    if re.search(r"^:(type|rtype)", text, re.MULTILINE):
        text = _inSections(text, _definitionOf(name))
    lines[:] = _linkCalls(_codeBlocks(text), name.split(".")[1]).split("\n")


def _inSections(text, definition):
    """Turn SWIG's fields into sections; its "out" parameters are results."""
    description, fields = _splitFields(text)
    parameters, results = [], []
    for name, (kind, about) in fields.items():
        if name == "return":
            results.insert(0, (None, kind, about))
        elif kind.endswith(", out"):
            results.append((name, kind.removesuffix(", out"), about))
        else:
            parameters.append((name, kind, about))
    returned = _STUB.get(ast.unparse(definition.returns)) if definition.returns else None
    if len(results) > 1 and results[0][0] is None and returned:  # a named tuple, whose first field also has a name
        results[0] = (_constructorOf(returned).args.args[0].arg, *results[0][1:])
    return "\n".join([description.rstrip(), *_section("Parameters", parameters), *_section("Returns", results), ""])


def _splitFields(text):
    """Return the text before the first field, and {name: (type, text)} of parameters and of "return"."""
    lines = text.split("\n")
    first = next(number for number, line in enumerate(lines) if _FIELD.match(line))
    fields, words = {}, None
    for line in lines[first:]:
        match = _FIELD.match(line)
        if match is None:
            words.append(line.strip())
            continue
        kind, name, rest = match.groups()
        field = fields.setdefault("return" if kind in ("rtype", "return") else name, ([], []))
        words = field[kind in ("param", "return")]
        words.append(rest)
    joined = {name: [" ".join(part).strip() for part in parts] for name, parts in fields.items()}
    return "\n".join(lines[:first]), {name: (_TYPES.get(kind, kind), about) for name, (kind, about) in joined.items()}


def _section(title, entries):
    if not entries:
        return []
    lines = ["", title, "-" * len(title)]
    for name, kind, about in entries:
        lines += [f"{name} : {kind}" if name else kind, textwrap.indent(about, "    ")]
    return lines


def _codeBlocks(text):
    """Make indented lines after an empty line a code block, in the text before the sections."""
    head, *sections = _SECTION.split(text)
    return "".join([_INDENTED.sub(r"::\n\n\1", head), *sections])


def _linkCalls(text, owner):
    """Link calls of methods of this package."""

    def link(match):
        named, method, arguments = match.groups()
        for one in (named,) if named else (owner, "StericExclusionForce", "TorsionMonteCarloIntegrator"):
            if f"{one}.{method}" in _STUB:
                return f":py:meth:`{method}({arguments}) <openmmchaintree.{one}.{method}>`"
        return match[0]

    return "\n".join(line if line.startswith("    ") else _CALL.sub(link, line) for line in text.split("\n"))
