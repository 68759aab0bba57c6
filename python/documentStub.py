"""Write the type stub of SWIG's module: the types of openmmchaintree.pyi with the documentation of the C++ headers.

Constants, and methods that openmmchaintree.pyi leaves out, such as those of moves, have the types of their docstrings
and the default values of the header.

python documentStub.py TYPES MODULE HEADERS STUB
"""

import ast
import re
import sys
import textwrap
from pathlib import Path


def main():
    types, module, headers, stub = map(Path, sys.argv[1:])
    tree = ast.parse(types.read_text(encoding="utf-8"))
    documented = ast.parse(module.read_text(encoding="utf-8"))
    classes = {node.name: node for node in documented.body if isinstance(node, ast.ClassDef)}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            header = headers / f"{node.name}.h"
            _addMembers(node, classes[node.name], header.read_text(encoding="utf-8") if header.exists() else "")
            _documentClass(node, classes[node.name])
    text = f"# Made from {types.name} and the C++ headers.\n\n{ast.unparse(tree)}\n"
    stub.write_text(text, encoding="utf-8")


def _addMembers(node, documented, header):
    """Add the constants of a class, and the public methods that are missing, in the order of the module."""
    constants = [name for name, _ in _documentedConstants(documented)]
    node.body[:0] = [ast.parse(f"{name}: int").body[0] for name in constants]
    known = {member.name: member for member in node.body if _isMethod(member)}
    methods = [member for member in documented.body if _isMethod(member)]
    missing = {
        method.name: _declare(method.name, ast.get_docstring(method), header)
        for method in methods
        if method.name not in known and not method.name.startswith("_")
    }
    order = {method.name: number for number, method in enumerate(methods)}
    others = [member for member in node.body if not _isMethod(member)]
    node.body = others + sorted([*known.values(), *missing.values()], key=lambda member: order[member.name])


_PARAMETER = re.compile(r"^:type (\w+): (.*?)(, out|, optional)?$", re.MULTILINE)
_TYPES = {"float or Quantity": "_Number", "sequence of int, or None": "_Indices | None"}
_DEFAULTS = {"std::vector<int>()": "None"}


def _declare(name, text, header):
    """Return a method with the types of its docstring, where results are parameters marked as out."""
    parameters, results = ["self"], []
    for parameter, kind, mark in _PARAMETER.findall(text):
        if mark == ", out":
            results.append(parameter)
            continue
        declaration = f"{parameter}: {_TYPES.get(kind, kind)}"
        if mark == ", optional":
            default = re.search(rf"\b{name}\((?:[^;()]|\(\))*\b{parameter} = ([\w.:<>]+(?:\(\))?)", header)[1]
            declaration += f" = {_DEFAULTS.get(default, default)}"
        parameters.append(declaration)
    returned = re.search(r"^:rtype: (.*)$", text, re.MULTILINE)
    result = "list[Any]" if results else returned[1] if returned else "None"
    return ast.parse(f"def {name}({', '.join(parameters)}) -> {result}: ...").body[0]


def _documentClass(node, documented):
    methods = {member.name: ast.get_docstring(member) for member in documented.body if _isMethod(member)}
    constants = dict(_documentedConstants(documented))
    members = [_docstring(ast.get_docstring(documented), depth=1)]
    for member in node.body:
        members.append(member)
        if _isMethod(member):
            member.body = [_docstring(methods[member.name], depth=2)]
        elif isinstance(member, ast.AnnAssign) and member.target.id in constants:
            members.append(_docstring(constants[member.target.id], depth=1))
    node.body = members


def _isMethod(node):
    return isinstance(node, ast.FunctionDef)


def _documentedConstants(documented):
    """Generate (name, docstring) of the constants that a string follows."""
    for member, after in zip(documented.body, documented.body[1:], strict=False):
        if isinstance(member, ast.Assign) and isinstance(after, ast.Expr):
            yield member.targets[0].id, after.value.value


def _docstring(text, depth):
    if "\n" in text:
        margin = "    " * depth
        text = f"\n{textwrap.indent(text, margin)}\n{margin}"
    return ast.Expr(ast.Constant(text))


main()
