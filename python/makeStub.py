"""Write the type stub of SWIG's module, with its documentation.

Names, parameters and documentation are those of the module. Types are taken from the first of these that has them:
openmmchaintree.pyi, annotations of methods written in Python, and the docstrings and C++ headers.

python makeStub.py TYPES MODULE HEADERS STUB
"""

import ast
import re
import sys
import textwrap
from pathlib import Path

# Types in docstrings and headers. Headers have enumerations, too, which are integers in Python.
_TYPES = {
    "double": "float",
    "boolean": "bool",
    "string": "str",
    "std::string": "str",
    "void": "None",
    ":py:class:`Context`": "openmm.Context",
    "float or Quantity": "_Number",
    "sequence of int": "_Indices",
    "sequence of int, or None": "_Indices | None",
}
_PREFIXES = {"sequence of": "_Vector", "numpy.ndarray of int32": "_Ints", "numpy.ndarray of float64": "_Floats"}
_DEFAULTS = {"std::vector<int>()": "None", "true": "True"}

_PARAMETER = re.compile(r"^:type (\w+): (.*?)(, out|, optional)?$", re.MULTILINE)


def main():
    types, module, headers, stub = map(Path, sys.argv[1:])
    tree = ast.parse(types.read_text(encoding="utf-8"))
    given = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    tree.body = [node for node in tree.body if node not in given.values()]
    for node in ast.parse(module.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            header = headers / f"{node.name}.h"
            known = {member.name: member for member in given[node.name].body} if node.name in given else {}
            node.body = _members(node, known, header.read_text(encoding="utf-8") if header.exists() else "")
            tree.body.append(node)
    text = f"# Made from {module.name}, {types.name} and the C++ headers.\n\n{ast.unparse(tree)}\n"
    stub.write_text(text, encoding="utf-8")


def _members(node, known, header):
    """Return the body of a class in the stub: constants, fields and public methods, with their documentation."""
    members = [_docstring(ast.get_docstring(node), depth=1)]
    for name, text in _constants(node):
        members += [ast.parse(f"{name}: int").body[0], _docstring(text, depth=1)]
    for member in node.body:
        if isinstance(member, ast.AnnAssign):
            members.append(member)
        elif isinstance(member, ast.FunctionDef) and (member.name == "__init__" or not member.name.startswith("_")):
            text = ast.get_docstring(member)
            if member.name in known:
                member = known[member.name]
            elif member.returns is None:
                member = _declare(member.name, text or "", header)
            if text is not None:
                member.body = [_docstring(text, depth=2)]
                members.append(member)
    return members


def _declare(name, text, header):
    """Return a method with types of its docstring, where results are parameters marked as out, and of the header."""
    parameters, results = ["self"], []
    for parameter, kind, mark in _PARAMETER.findall(text):
        if mark == ", out":
            results.append(_typeOf(kind))
            continue
        declaration = f"{parameter}: {_typeOf(kind)}"
        if mark == ", optional":
            default = re.search(rf"\b{name}\((?:[^;()]|\(\))*\b{parameter} = ([\w.:<>]+(?:\(\))?)", header)[1]
            declaration += f" = {_DEFAULTS.get(default, default)}"
        parameters.append(declaration)
    returned = re.search(r"^:rtype: (.*)$", text, re.MULTILINE)
    if returned is None:
        returned = re.search(rf"^\s*(?:const )?([\w:]+)&? {name}\(", header, re.MULTILINE)
    result = _resultOf(results) if results else _typeOf(returned[1]) if returned else "None"
    return ast.parse(f"def {name}({', '.join(parameters)}) -> {result}: ...").body[0]


def _typeOf(kind):
    prefixed = next((name for prefix, name in _PREFIXES.items() if kind.startswith(prefix)), None)
    isEnumeration = kind[:1].isupper() and kind != "EnergyPlan"
    return _TYPES.get(kind) or prefixed or ("int" if isEnumeration else kind)


def _resultOf(results):
    """Return the type of a method with some results: several arrays are a tuple, and other things a list."""
    if all(result in ("_Ints", "_Floats") for result in results):
        return results[0] if len(results) == 1 else f"tuple[{', '.join(results)}]"
    return "list[int]" if set(results) == {"int"} else "list[Any]"


def _constants(node):
    """Generate (name, docstring) of the constants that a string follows."""
    for member, after in zip(node.body, node.body[1:], strict=False):
        if isinstance(member, ast.Assign) and isinstance(after, ast.Expr):
            yield member.targets[0].id, after.value.value


def _docstring(text, depth):
    if "\n" in text:
        margin = "    " * depth
        text = f"\n{textwrap.indent(text, margin)}\n{margin}"
    return ast.Expr(ast.Constant(text))


main()
