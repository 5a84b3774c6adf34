#!/usr/bin/env python3
"""The type hints and docstrings beside the module itself."""

import ast
import enum
import inspect
import pathlib
import unittest

import cases
from cases import proximity
from proximity import _native

FOLDER = pathlib.Path(proximity.__file__).parent
STUB = ast.parse((FOLDER / "_native.pyi").read_text())


def public(names):
    return sorted(name for name in names if not name.startswith("_"))


def stub_classes():
    return {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}


def stub_arguments(function):
    """(name, kind, default as text) of each argument but self, as inspect has them; no default is None."""
    found = function.args
    plain = found.posonlyargs + found.args
    defaults = [None] * (len(plain) - len(found.defaults)) + found.defaults
    text = lambda default: default and ast.unparse(default)
    listed = [(argument.arg, "positional or keyword", text(default)) for argument, default in zip(plain, defaults)]
    listed += [(argument.arg, "keyword-only", text(default)) for argument, default in zip(found.kwonlyargs, found.kw_defaults)]
    return [entry for entry in listed if entry[0] != "self"]


def real_arguments(name, doc):
    """The same of the first line of a docstring: minimum(self: proximity.Robot, q: object) -> object."""
    arguments = ast.parse(f"def {doc.splitlines()[0]}: ...".replace("proximity._native.", "")).body[0]
    assert arguments.name == name, doc
    return stub_arguments(arguments)


class Types(unittest.TestCase):
    def test_the_stub_has_the_names_of_the_compiled_part(self):
        declared = [node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)]
        self.assertEqual(public(vars(_native)), sorted([*public(declared), *stub_classes()]))

    def test_the_stub_has_the_members_of_each_class(self):
        for name, node in stub_classes().items():
            with self.subTest(name):
                members = {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
                self.assertEqual(public(vars(getattr(_native, name))), public(members))

    def test_properties_of_the_stub_are_properties_that_may_be_set_or_not(self):
        for name, node in stub_classes().items():
            for member in node.body:
                decorators = [ast.unparse(decorator) for decorator in getattr(member, "decorator_list", [])]
                if "property" not in decorators:
                    continue
                with self.subTest(f"{name}.{member.name}"):
                    real = vars(getattr(_native, name))[member.name]
                    self.assertIsInstance(real, property)
                    settable = any(f"{member.name}.setter" in map(ast.unparse, getattr(other, "decorator_list", []))
                                   for other in node.body)
                    self.assertEqual(settable, real.fset is not None)

    def test_the_stub_has_the_arguments_and_defaults_of_each_method(self):
        compared = 0
        for name, node in stub_classes().items():
            for member in node.body:
                decorators = [ast.unparse(decorator) for decorator in getattr(member, "decorator_list", [])]
                if not isinstance(member, ast.FunctionDef) or set(decorators) - {"staticmethod"}:
                    continue
                with self.subTest(f"{name}.{member.name}"):
                    real = inspect.getattr_static(getattr(_native, name), member.name)
                    self.assertEqual("staticmethod" in decorators, isinstance(real, staticmethod))
                    doc = getattr(getattr(_native, name), member.name).__doc__
                    self.assertEqual(stub_arguments(member), real_arguments(member.name, doc))
                    compared += 1
        self.assertEqual(25, compared)

    def test_a_marker_tells_type_checkers_that_there_are_types(self):
        self.assertTrue((FOLDER / "py.typed").exists())

    def test_all_names_are_documented(self):
        self.assertEqual(public(vars(proximity)), sorted({*public(proximity.__all__), "enum"}))
        documented = [proximity, *(thing for name in proximity.__all__ if isinstance(thing := getattr(proximity, name), type))]
        documented += [value for owner in (proximity.Robot, proximity.Joint) for name, value in vars(owner).items()
                       if not name.startswith("_")]
        self.assertEqual([], [thing for thing in documented if not inspect.getdoc(thing)])
        self.assertIn("mesh_tolerance", proximity.Robot.__init__.__doc__)

    def test_the_fields_of_the_rows_are_documented(self):
        for dtype in (proximity.LEVELED_PAIR, proximity.VERDICT, proximity.CONTACT, proximity.EDGE_MINIMUM,
                      proximity.PROOF, proximity.POINT, proximity.HIT):
            for name in dtype.names:
                with self.subTest(name):
                    self.assertRegex(proximity.__doc__, rf"(?m)^    (\w+, )*{name}\b")

    def test_rows_have_no_byte_that_belongs_to_no_field(self):
        for dtype in (proximity.PAIR, proximity.LEVELED_PAIR, proximity.VERDICT, proximity.CONTACT, proximity.EDGE_MINIMUM,
                      proximity.PROOF, proximity.POINT, proximity.HIT):
            self.assertEqual(dtype.itemsize, sum(dtype[name].itemsize for name in dtype.names))

    def test_numbers_of_the_enumerations_begin_with_no_answer(self):
        self.assertTrue(issubclass(proximity.Status, enum.IntEnum))
        self.assertEqual((0, 0, 0), (proximity.Status.UNKNOWN, proximity.Verdict.UNKNOWN, proximity.Hit.UNKNOWN))


if __name__ == "__main__":
    cases.main()
