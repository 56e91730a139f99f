# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""LLVM at work: texts of modules -> object code -> functions in memory.

The only module that knows llvmlite, an optional package.  No IR passes run: values are forwarded
when the text is made, and FastISel then gives the code of the optimiser in a tenth of the time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
import ctypes
import ctypes.util
from functools import cache
from typing import Any

from ladder_ros.compiler.object_cache import ObjectCache


@cache
def _llvm() -> Any:
    """Return llvmlite's binding, set up once."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    llvm.set_option('ladder_ros', '-fast-isel')
    return llvm


@cache
def _functions_of_c() -> Mapping[str, int]:
    """Return where the functions are that native code calls for REALs, by name."""
    library = ctypes.CDLL(ctypes.util.find_library('m'))
    places = {name: ctypes.cast(getattr(library, name), ctypes.c_void_p).value for name in (
        'sin', 'cos', 'tan', 'asin', 'acos', 'atan', 'exp', 'log', 'log10', 'pow')}
    return {name: place for name, place in places.items() if place}


@cache
def why_missing() -> str:
    """Return why there is no native code here, or ''."""
    try:
        _machine()
    except ImportError:
        return 'llvmlite is not installed'
    except (OSError, RuntimeError) as error:  # installed for another machine, say
        return f'llvmlite does not work here: {error}'
    return ''


@cache
def _machine() -> Any:
    llvm = _llvm()
    features = llvm.get_host_cpu_features().flatten()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=features, opt=1, reloc='pic', codemodel='small')


@cache
def _identity() -> str:
    """Return all that object code depends on besides the text it is made from."""
    import llvmlite

    llvm = _llvm()
    return ' '.join((
        llvmlite.__version__, str(llvm.llvm_version_info), llvm.get_default_triple(),
        llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(),
        'fast-isel pic small nounwind 1'))


def make_object(text: str, cached: ObjectCache | None = None) -> bytes:
    """Return the object code of a module, from the cache if it is there."""
    key = cached.key(text, _identity()) if cached is not None else ''
    if cached is not None:
        found = cached.read(key)
        if found is not None:
            return found
    module = _llvm().parse_assembly(text)
    for function in module.functions:  # else there are tables for exceptions, which nobody throws
        function.add_function_attribute('nounwind')
    made: bytes = _machine().emit_object(module)
    if cached is not None:
        cached.write(key, made)
    return made


class Linked:
    """Object code in memory, ready to be called; freed with the last one who has it."""

    def __init__(self, objects: Iterable[bytes], symbols: Iterable[str]) -> None:
        """Link objects that may refer to each other; the ``symbols`` are functions of theirs.

        Nothing but the code is kept: no object, no names, no tables for unwinding.
        """
        llvm = _llvm()
        # One of its own for each program: an engine never forgets what it has linked.
        self._engine = llvm.create_lljit_compiler(use_jit_link=True)
        library = llvm.JITLibraryBuilder().add_current_process()  # memcpy, say
        for name, place in _functions_of_c().items():
            library.import_symbol(name, place)
        for data in objects:
            library.add_object_img(data)
        for symbol in symbols:
            library.export_symbol(symbol)
        self._library = library.link(self._engine, 'program')

    def function(self, symbol: str, *arguments: Any) -> Callable[..., int]:
        """Return a function that returns an i8; without types, arguments are not converted."""
        function = ctypes.CFUNCTYPE(ctypes.c_int8, *arguments)(self.address(symbol))
        if not arguments:
            function.argtypes = None  # type: ignore[assignment]
        return function

    def address(self, symbol: str) -> int:
        """Return where a function is, one of the symbols."""
        found: int = self._library[symbol]
        return found
