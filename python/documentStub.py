"""Write the type stub of SWIG's module: the types of openmmchaintree.pyi with the documentation of the C++ headers.

python documentStub.py TYPES MODULE STUB
"""

import ast
import sys
import textwrap
from pathlib import Path


def main():
    types, module, stub = map(Path, sys.argv[1:])
    tree = ast.parse(types.read_text(encoding="utf-8"))
    documented = ast.parse(module.read_text(encoding="utf-8"))
    classes = {node.name: node for node in documented.body if isinstance(node, ast.ClassDef)}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            _documentClass(node, classes[node.name])
    text = f"# Made from {types.name} and the C++ headers.\n\n{ast.unparse(tree)}\n"
    stub.write_text(text, encoding="utf-8")


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
