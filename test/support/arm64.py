# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A 64-bit ARM on which native code runs in tests: objects for it are linked and emulated.

Registers and code are the emulator's.  The memory of this process is there at its own addresses,
so that what is called works on the very state that Python has.  Relocations are those of *ELF for
the Arm 64-bit Architecture* (IHI 0056) that LLVM's small code model uses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
import ctypes
import ctypes.util
from functools import cache
import io
import math
import struct
from typing import Any

from elftools.elf.elffile import ELFFile
from elftools.elf.relocation import RelocationSection
import llvmlite.binding as llvm
import unicorn
from unicorn import arm64_const as arm

CODE, CODE_SIZE = 0x1000_0000, 0x600_0000
STACK, STACK_SIZE = 0x0F00_0000, 0x80_0000
OUTSIDE = 0x0F80_0000
"""Where functions are that code calls and that this process has; within reach of a BL."""
RETURN = 0xD65F03C0
PAGE = 4096
OWN = CODE + CODE_SIZE
"""Addresses from here on are memory of this process."""
ARGUMENTS = (arm.UC_ARM64_REG_X0, arm.UC_ARM64_REG_X1, arm.UC_ARM64_REG_X2)

_GOT = {311: 275, 312: 286}
"""Relocations against an entry of the global offset table, and those that they are then."""
_LOW_BITS = {277: 0, 278: 0, 284: 1, 285: 2, 286: 3, 299: 4}
"""Relocations of the low twelve bits of an address: by how much they are scaled."""


@cache
def machine() -> Any:
    """Return what emits code for it; it must have been initialised."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple('aarch64-unknown-linux-gnu').create_target_machine(
        opt=1, reloc='pic', codemodel='small')


class Arm64:
    """The processor, with the code that was loaded."""

    def __init__(self) -> None:
        """Switch it on."""
        self.calls = 0
        self._uc = unicorn.Uc(unicorn.UC_ARCH_ARM64, unicorn.UC_MODE_ARM)
        self._uc.ctl_set_cpu_model(arm.UC_CPU_ARM64_MAX)
        self._uc.reg_write(arm.UC_ARM64_REG_CPACR_EL1, 3 << 20)  # lets it compute with floats
        self._uc.mem_map(CODE, CODE_SIZE)
        self._uc.mem_map(STACK - STACK_SIZE, STACK_SIZE)
        self._uc.mem_map(OUTSIDE, PAGE)
        self._uc.mem_write(OUTSIDE, struct.pack('<I', RETURN) * (PAGE // 4))
        self._uc.hook_add(unicorn.UC_HOOK_MEM_UNMAPPED, self._show_own)
        self._end = CODE
        self._pages: set[int] = set()
        self._outside: dict[str, int] = {}

    def _show_own(
        self, uc: Any, access: int, address: int, size: int, _value: int, _data: object,
    ) -> bool:
        """Let it see memory of this process."""
        if access == unicorn.UC_MEM_FETCH_UNMAPPED or not OWN <= address < 1 << 47:
            return False
        for page in {address // PAGE * PAGE, (address + size - 1) // PAGE * PAGE} - self._pages:
            self._pages.add(page)
            uc.mem_map_ptr(page, PAGE, unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE,
                           ctypes.c_void_p(page))
        return True

    def call(self, address: int, *arguments: Any) -> int:
        """Call a function that returns an i8."""
        self.calls += 1
        for register, argument in zip(ARGUMENTS, arguments, strict=False):
            number = argument if isinstance(argument, int) else argument.value or 0
            self._uc.reg_write(register, number & (1 << 64) - 1)
        self._uc.reg_write(arm.UC_ARM64_REG_SP, STACK - 64)
        self._uc.reg_write(arm.UC_ARM64_REG_LR, OUTSIDE)
        self._uc.emu_start(address, OUTSIDE)
        return ctypes.c_int8(self._uc.reg_read(arm.UC_ARM64_REG_X0) & 0xFF).value

    # -- memory -----------------------------------------------------------------------------------

    def place(self, data: bytes, align: int) -> int:
        """Write bytes where there is room; return the address."""
        start = -(-self._end // align) * align
        self._end = start + len(data)
        assert self._end <= CODE + CODE_SIZE, 'the emulated machine is full'
        self._uc.mem_write(start, data)
        return start

    def read(self, address: int, size: int) -> bytes:
        """Return bytes, the machine's or this process'."""
        if address < OWN:
            return bytes(self._uc.mem_read(address, size))
        return ctypes.string_at(address, size)

    def write(self, address: int, data: bytes) -> None:
        """Write bytes."""
        if address < OWN:
            self._uc.mem_write(address, data)
        else:
            ctypes.memmove(address, data, len(data))

    # -- functions of C ---------------------------------------------------------------------------

    def outside(self, name: str) -> int:
        """Return the address of a function of the C library, which Python executes."""
        if name not in self._outside:
            place = self._outside[name] = OUTSIDE + 16 * (len(self._outside) + 1)
            function = self._of_memory(name) if name.startswith('mem') else self._of_floats(name)
            self._uc.hook_add(
                unicorn.UC_HOOK_CODE, lambda *_: function(), begin=place, end=place)
        return self._outside[name]

    def _of_memory(self, name: str) -> Callable[[], None]:
        def function() -> None:
            target, source, size = (self._uc.reg_read(register) for register in ARGUMENTS)
            self.write(target, bytes([source & 0xFF]) * size if name == 'memset'
                       else self.read(source, size))
        assert name in ('memcpy', 'memmove', 'memset'), name
        return function

    def _of_floats(self, name: str) -> Callable[[], None]:
        count = 2 if name == 'pow' else 1
        called = getattr(ctypes.CDLL(ctypes.util.find_library('m')), name)
        called.restype, called.argtypes = ctypes.c_double, [ctypes.c_double] * count

        def function() -> None:
            given = [struct.unpack('<d', struct.pack('<Q', self._uc.reg_read(
                arm.UC_ARM64_REG_D0 + number)))[0] for number in range(count)]
            self._uc.reg_write(arm.UC_ARM64_REG_D0, struct.unpack(
                '<Q', struct.pack('<d', called(*given)))[0])
        assert hasattr(math, name), name
        return function


class Emulated:
    """Stands for `llvm_machine.Linked`: the same objects, on that machine."""

    processor = Arm64()

    def __init__(self, objects: Iterable[bytes], _symbols: Iterable[str] = ()) -> None:
        """Link objects that may refer to each other."""
        self._symbols: dict[str, int] = {}
        self._table: dict[int, int] = {}
        loaded = [self._load(ELFFile(io.BytesIO(data))) for data in objects]
        for elf, places in loaded:
            for section in elf.iter_sections():
                if isinstance(section, RelocationSection) and section['sh_info'] in places:
                    for entry in section.iter_relocations():
                        self._relocate(elf, places, places[section['sh_info']], entry)

    def function(self, symbol: str, *_types: Any) -> Callable[..., int]:
        """Return a function that can be called."""
        address = self.address(symbol)
        return lambda *arguments: self.processor.call(address, *arguments)

    def address(self, symbol: str) -> int:
        """Return where a symbol is."""
        return self._symbols[symbol]

    def _load(self, elf: Any) -> tuple[Any, dict[int, int]]:
        assert elf['e_machine'] == 'EM_AARCH64'
        places = {
            number: self.processor.place(section.data(), max(16, section['sh_addralign']))
            for number, section in enumerate(elf.iter_sections())
            if section['sh_flags'] & 2 and section['sh_size']}
        for symbol in elf.get_section_by_name('.symtab').iter_symbols():
            if symbol['st_info']['bind'] == 'STB_GLOBAL' and symbol['st_shndx'] in places:
                self._symbols[symbol.name] = places[symbol['st_shndx']] + symbol['st_value']
        return elf, places

    def _relocate(self, elf: Any, places: dict[int, int], base: int, entry: Any) -> None:
        symbol = elf.get_section_by_name('.symtab').get_symbol(entry['r_info_sym'])
        if symbol['st_shndx'] in places:
            target = places[symbol['st_shndx']] + symbol['st_value']
        elif symbol.name in self._symbols:
            target = self._symbols[symbol.name]
        else:
            target = self.processor.outside(symbol.name)
        target += entry['r_addend']
        kind, place = entry['r_info_type'], base + entry['r_offset']
        if kind in _GOT:
            kind = _GOT[kind]
            if target not in self._table:
                self._table[target] = self.processor.place(struct.pack('<Q', target), 8)
            target = self._table[target]
        if kind == 257:
            self.processor.write(place, struct.pack('<Q', target))
        elif kind in (260, 261):
            self.processor.write(place, struct.pack(
                '<q' if kind == 260 else '<i', target - place))
        else:
            mask, bits = _field(kind, target, place)
            word, = struct.unpack('<I', self.processor.read(place, 4))
            self.processor.write(place, struct.pack('<I', word & ~mask | bits & mask))


def _field(kind: int, target: int, place: int) -> tuple[int, int]:
    """Return the bits of an instruction that a relocation changes, and what they become."""
    if kind in (282, 283):  # B, BL
        assert abs(target - place) < 1 << 27
        return 0x03FF_FFFF, target - place >> 2
    if kind == 275:  # ADRP
        pages = target // PAGE - place // PAGE
        return 0x60FF_FFE0, (pages & 3) << 29 | (pages >> 2 & 0x7FFFF) << 5
    return 0x003F_FC00, (target % PAGE >> _LOW_BITS[kind]) << 10
