"""The stubs declare what the extension has, with its arguments."""

import ast
import inspect
from pathlib import Path

import lifelike
from lifelike import _lifelike

STUB = ast.parse((Path(lifelike.__file__).parent / "_lifelike.pyi").read_text())


def arguments(function):
    declared = function.args
    keywords = [declared.kwarg] if declared.kwarg else []
    names = [*declared.posonlyargs, *declared.args, *declared.kwonlyargs, *keywords]
    return [name.arg for name in names if name.arg not in ("self", "cls")]


def found(value):
    return [name for name in inspect.signature(value).parameters if name != "self"]


def public(value):
    return {name for name in vars(value) if not name.startswith("_")}


def test_every_name_is_declared_and_documented():
    declared = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    declared = {name: node for name, node in declared.items() if not name.startswith("_")}
    assert set(declared) == public(_lifelike) and set(lifelike.__all__) == set(declared) - {"main"} | {"__version__"}
    checked = 0
    for name, node in declared.items():
        value = getattr(_lifelike, name)
        assert value.__doc__ or name == "SavedState", name
        if isinstance(node, ast.FunctionDef):
            assert arguments(node) == found(value), name
            continue
        members = {member.name: member for member in node.body if isinstance(member, ast.FunctionDef)}
        assert {m for m in members if not m.startswith("_")} == public(value), name
        if "__new__" in members:
            assert arguments(members["__new__"]) == found(value), name
        for method, member in members.items():
            if not method.startswith("_") and not member.decorator_list:
                assert arguments(member) == found(getattr(value, method)), f"{name}.{method}"
                checked += 1
    assert checked > 15
