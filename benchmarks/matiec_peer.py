# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The other peer of the benchmarks: a plant compiled by MatIEC itself, where it is installed.

The plant is exported as Structured Text, its inputs and outputs located as they are in OpenPLC and
Beremiz; ``iec2c`` makes C of it and gcc a library.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
import shutil
import subprocess

from c_peer import Peer
from support.plants import Plant, program_of

from ladder_ros.compiler.program_to_st import write_st
from ladder_ros.model.program import Program, Variable, VariableClass

_DRIVER = """
#include "iec_std_lib.h"
#include "accessor.h"
#include "POUS.h"
extern MAIN RESOURCE1__INSTANCE0;
TIME __CURRENT_TIME;
void config_init__(void);
void config_run__(unsigned long tick);
static BOOL image[{located}];
{pointers}
static BOOL *const places[] = {{ {places} }};
static unsigned long tick;
void begin(void) {{ config_init__(); }}
void scan(int64_t now) {{
  __CURRENT_TIME.tv_sec = now / 1000000000;
  __CURRENT_TIME.tv_nsec = now % 1000000000;
  config_run__(tick++);
}}
void put(int k, BOOL v) {{ *places[k] = v; }}
BOOL get(int k) {{ return *places[k]; }}
"""


def iec2c() -> str | None:
    """Return where MatIEC's compiler is, if it is on the PATH."""
    return shutil.which('iec2c')


def matiec_peer(plant: Plant, library: Path, folder: Path) -> Peer:
    """Have a plant compiled by MatIEC and gcc, and load it; ``library`` is MatIEC's ``lib``."""
    compiler, gcc = iec2c(), shutil.which('gcc')
    if compiler is None or gcc is None:
        raise SystemExit('iec2c and gcc have to be on the PATH')
    if not (library / 'C' / 'iec_std_lib.h').is_file():
        raise SystemExit(f'{library} is not the folder lib of MatIEC: no C/iec_std_lib.h')
    folder.mkdir(parents=True, exist_ok=True)
    program = _located(program_of(plant))
    (folder / 'plant.st').write_text(write_st(program))
    _run([compiler, '-I', str(library), '-T', str(folder), str(folder / 'plant.st')], folder)
    (folder / 'driver.c').write_text(_driver(program))
    peer = folder / 'peer.so'
    _run([gcc, '-O2', '-w', '-fPIC', '-shared', '-I', str(library / 'C'), '-I', str(folder),
          '-o', str(peer), *(str(folder / name) for name in (
              'driver.c', 'config.c', 'resource1.c'))], folder)
    return Peer(
        peer, {variable.name: place for place, variable in enumerate(program.variables)})


def _located(program: Program) -> Program:
    """Give every input and output an address."""
    def places() -> Iterator[Variable]:
        for number, variable in enumerate(program.variables):
            kind = {VariableClass.INPUT: 'I', VariableClass.OUTPUT: 'Q'}.get(
                variable.variable_class)
            yield variable if kind is None else replace(
                variable, variable_class=VariableClass.LOCAL,
                address=f'%{kind}X{number // 8}.{number % 8}')

    return replace(program, variables=tuple(places()))


def _driver(program: Program) -> str:
    located = [variable for variable in program.variables if variable.address]
    pointers = '\n'.join(
        f'BOOL *__{variable.address[1:].replace(".", "_")} = image + {place};'
        for place, variable in enumerate(located))
    images = {variable.name: place for place, variable in enumerate(located)}
    return _DRIVER.format(
        located=len(located), pointers=pointers, places=', '.join(
            f'image + {images[variable.name]}' if variable.address
            else f'&RESOURCE1__INSTANCE0.{variable.name.upper()}.value'
            for variable in program.variables))


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    if done.returncode:
        raise SystemExit(f'{command[0]} failed on {folder}:\n{done.stdout}{done.stderr}')
