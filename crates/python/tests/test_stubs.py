"""The stub says of the compiled half what that says of itself: every name, every argument, every default."""

import ast
import inspect
import pathlib
import sys

import umbrage
from umbrage import _umbrage

STUB = pathlib.Path(umbrage.__file__).with_name("_umbrage.pyi")


def stubs(body):
    """Name of all in a module's or a class's body, with the signature of functions that have one alone."""
    for node in body:
        if isinstance(node, ast.FunctionDef):
            decorators = {getattr(decorator, "id", None) for decorator in node.decorator_list}
            arguments = list(parameters(node.args))
            yield node.name, None if decorators & {"property", "overload"} else arguments
        elif isinstance(node, ast.AnnAssign):
            yield node.target.id, None
        elif isinstance(node, ast.ClassDef):
            yield from ((f"{node.name}.{name}", of) for name, of in stubs(node.body))


def parameters(arguments):
    """Name, whether it is a keyword alone, and default of each."""
    positional = arguments.args
    without = len(positional) - len(arguments.defaults)
    for number, argument in enumerate(positional):
        if argument.arg not in ("self", "cls"):
            yield argument.arg, False, value(arguments.defaults[number - without] if number >= without else None)
    for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults):
        yield argument.arg, True, value(default)


def value(node):
    return "none" if node is None else repr(ast.literal_eval(node))


def compiled():
    """The same of the module."""
    for name, of in vars(_umbrage).items():
        if isinstance(of, type):
            if of.__text_signature__ is not None:
                yield f"{name}.__new__", signature(of)
            public = (member for member in vars(of) if not member.startswith("_"))
            for member in public:
                function = getattr(of, member)
                yield f"{name}.{member}", signature(function) if callable(function) else None
        elif callable(of) and not name.startswith("_"):
            yield name, signature(of)
    yield "__version__", None


def signature(of):
    all = inspect.signature(of).parameters.values()
    if any(parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD) for parameter in all):
        return None
    return [
        (
            parameter.name,
            parameter.kind is parameter.KEYWORD_ONLY,
            "none" if parameter.default is parameter.empty else repr(parameter.default),
        )
        for parameter in all
        if parameter.name != "self"
    ]


def test_the_stub_is_the_module():
    said = dict(stubs(ast.parse(STUB.read_text(encoding="utf-8")).body))
    found = dict(compiled())
    if sys.version_info < (3, 10):
        # Classes of libraries don't say what they are made of before.
        said = {name: of for name, of in said.items() if not name.endswith(".__new__")}
    assert said.keys() == found.keys()
    for name in found:
        assert said[name] == found[name], name


def test_the_stub_is_found_by_type_checkers():
    assert STUB.with_name("py.typed").exists()
    assert set(umbrage.__all__) - {"Picture"} <= set(vars(_umbrage)), "all that the package exports is in the stub"
