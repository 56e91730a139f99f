# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The peer of the benchmarks: a plant as C, in MatIEC's style and as an expert would write it.

MatIEC's style: a variable is a structure of a value and flags, each write looks at the force
flag; inputs and outputs are located, so that they are pointers; each rung is one expression with
operators that stop early, and a timer is a function of its structure.  To 2021, and in OpenPLC 3,
each read of a located variable looks at the flag too; since then a force exchanges the pointer.
The expert's: a byte a variable, and operators without branches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
import ctypes
from pathlib import Path
import re
import shutil
import subprocess

from support.plants import Plant, Spec, STATION_OUTPUTS

_RUNGS = 100
"""Rungs in a C function."""
_FUNCTIONS = 20
"""C functions in a file."""
_WITHOUT_STRINGS = ('-fno-optimize-strlen',)
"""The code is the same, as it has no strings, after half the time."""

_COMMON = """
#include <stdint.h>
typedef uint8_t BOOL; typedef int64_t TIME; typedef int16_t INT;
extern TIME now;
"""

_MATIEC = _COMMON + """
typedef struct { BOOL value; uint8_t flags; } V;
typedef struct { BOOL *value; uint8_t flags; BOOL forced; } L;
#define GET(x) ((x).value)
#define SET(x, e) do { if (!((x).flags & 2)) (x).value = (e); } while (0)
#define GET_LOCATED(x) (((x).flags & 2) ? (x).forced : *(x).value)
#define SET_LOCATED(x, e) do { if (!((x).flags & 2)) *(x).value = (e); } while (0)
typedef struct { V EN, ENO, IN; TIME PT; V Q; TIME ET; int8_t STATE; V PREV; TIME START; } TON;
static void ton(TON *d) {
  if (GET(d->EN)) { SET(d->ENO, 1); } else { SET(d->ENO, 0); return; }
  if (d->STATE == 0 && !GET(d->PREV) && GET(d->IN)) {
    d->STATE = 1; SET(d->Q, 0); d->START = now;
  } else if (!GET(d->IN)) {
    d->ET = 0; SET(d->Q, 0); d->STATE = 0;
  } else if (d->STATE == 1) {
    if (d->START + d->PT <= now) { d->STATE = 2; SET(d->Q, 1); d->ET = d->PT; }
    else d->ET = now - d->START;
  }
  SET(d->PREV, GET(d->IN));
}
typedef struct { V EN, ENO, CU, R; INT PV; V Q; INT CV; V PREV; } CTU;
static void ctu(CTU *d) {
  if (GET(d->EN)) { SET(d->ENO, 1); } else { SET(d->ENO, 0); return; }
  if (GET(d->R)) d->CV = 0;
  else if (GET(d->CU) && !GET(d->PREV) && d->CV < d->PV) d->CV++;
  SET(d->Q, d->CV >= d->PV);
  SET(d->PREV, GET(d->CU));
}
"""

_EXPERT = _COMMON + """
typedef BOOL V;
typedef struct { TIME ET, START; BOOL Q, PREV, RUN; } TON;
static inline void ton(TON *d, BOOL in, TIME pt) {
  TIME gone = now - d->START;
  BOOL begin = in & !d->PREV, run = in & d->RUN & d->PREV, over = run & (gone >= pt);
  d->ET = in ? (begin ? 0 : run ? (over ? pt : gone) : d->ET) : 0;
  d->START = begin ? now : d->START;
  d->Q = in & !begin & (d->Q | over);
  d->RUN = begin | (run & !over);
  d->PREV = in;
}
typedef struct { INT CV; BOOL Q, PREV; } CTU;
static inline void ctu(CTU *d, BOOL cu, BOOL r, INT pv) {
  INT cv = d->CV + ((cu & !d->PREV) & (d->CV < pv));
  d->CV = r ? 0 : cv;
  d->Q = d->CV >= pv;
  d->PREV = cu;
}
"""

_ACCESS = re.compile(r'\b(GET|SET)\((\w+)')
_VARIABLE = re.compile(r'\b((?:b_)?[kxmqi]\d+(?:_\d+)?|common)\b')

_CHECKED_READ = '#define GET_LOCATED(x) (((x).flags & 2) ? (x).forced : *(x).value)'
assert _CHECKED_READ in _MATIEC
STYLES = {
    'matiec': _MATIEC,
    'matiec 2022': _MATIEC.replace(_CHECKED_READ, '#define GET_LOCATED(x) (*(x).value)'),
    'expert': _EXPERT,
}
"""What a style's files begin with."""


def _flat(plant: Plant) -> Iterator[Spec]:
    """Yield all rungs; those of stations with their own names."""
    yield from plant.rungs
    for k in range(plant.stations):
        def own(name: str, k: int = k) -> str:
            return name if name in ('', 'common') else f'{name}_{k}'

        for spec in plant.station:
            yield Spec(
                groups=tuple(tuple((own(name), negated) for name, negated in group)
                             for group in spec.groups),
                target=own(spec.target), kind=spec.kind, preset=spec.preset,
                reset=own(spec.reset))


def _matiec_rung(spec: Spec) -> str:
    power = ' || '.join('(' + ' && '.join(
        f'{"!" if negated else ""}GET({name})' for name, negated in group) + ')'
        for group in spec.groups)
    match spec.kind:
        case 'coil':
            return f'SET({spec.target}, {power});'
        case 'set' | 'reset':
            return f'if ({power}) {{ SET({spec.target}, {int(spec.kind == "set")}); }}'
        case 'ton':
            b = f'b_{spec.target}'
            return (f'SET({b}.EN, 1); SET({b}.IN, {power}); {b}.PT = {spec.preset}000000LL; '
                    f'ton(&{b}); SET({spec.target}, GET({b}.Q));')
        case _:
            b = f'b_{spec.target}'
            return (f'SET({b}.EN, 1); SET({b}.CU, {power}); SET({b}.R, GET({spec.reset})); '
                    f'{b}.PV = {spec.preset}; ctu(&{b}); SET({spec.target}, GET({b}.Q));')


def _expert_rung(spec: Spec) -> str:
    power = ' | '.join('(' + ' & '.join(
        f'({name} ^ 1)' if negated else name for name, negated in group) + ')'
        for group in spec.groups)
    b = f'b_{spec.target}'
    match spec.kind:
        case 'coil':
            return f'{spec.target} = {power};'
        case 'set':
            return f'{spec.target} |= {power};'
        case 'reset':
            return f'{spec.target} &= ({power}) ^ 1;'
        case 'ton':
            return f'ton(&{b}, {power}, {spec.preset}000000LL); {spec.target} = {b}.Q;'
        case _:
            return f'ctu(&{b}, {power}, {spec.reset}, {spec.preset}); {spec.target} = {b}.Q;'


def _outputs(plant: Plant) -> set[str]:
    """Return the names of a plant's outputs."""
    if plant.stations:
        return {f'q{number}_{k}' for k in range(plant.stations)
                for number in range(STATION_OUTPUTS)}
    return {spec.target for spec in plant.rungs[::10]}


class Peer:
    """A plant as a loaded library: its inputs are written, it scans, its variables are read."""

    def __init__(self, library: Path, places: Mapping[str, int]) -> None:
        """Load it; it knows a variable by its place."""
        self.places = places
        loaded = ctypes.CDLL(str(library))
        loaded.scan.argtypes = [ctypes.c_int64]
        loaded.put.argtypes = [ctypes.c_int, ctypes.c_uint8]
        loaded.get.argtypes, loaded.get.restype = [ctypes.c_int], ctypes.c_uint8
        loaded.begin()
        self.scan, self._put, self._get = loaded.scan, loaded.put, loaded.get

    def write(self, name: str, value: bool) -> None:
        """Set a variable."""
        self._put(self.places[name], value)

    def read(self, name: str) -> bool:
        """Return a variable."""
        return bool(self._get(self.places[name]))


def c_peer(plant: Plant, style: str, folder: Path, flags: str = '-O2') -> Peer:
    """Generate, compile and load a plant in a style."""
    folder.mkdir(parents=True, exist_ok=True)
    specs = list(_flat(plant))
    outputs = [spec.target for spec in specs]
    names = list(dict.fromkeys((*plant.inputs, *outputs)))
    blocks = [(spec.kind.upper(), f'b_{spec.target}') for spec in specs
              if spec.kind in ('ton', 'ctu')]
    by_expert = style == 'expert'
    rung = _expert_rung if by_expert else _matiec_rung
    located = set() if by_expert else set(plant.inputs) | _outputs(plant)
    # One structure for all, in the order of the variables, as MatIEC has it.
    fields = ''.join(
        f'{"L" if name in located else "V"} {name};' for name in names) + ''.join(
        f'{kind} {name};' for kind, name in blocks)
    head = STYLES[style] + f'typedef struct {{ {fields} }} ALL;\nextern ALL all;\n'
    (folder / 'all.h').write_text(head)
    bodies = _functions(specs, rung, located)
    files = []
    for number, start in enumerate(range(0, len(bodies), _FUNCTIONS)):
        files.append(folder / f'part{number}.c')
        files[-1].write_text('#include "all.h"\n' + '\n'.join(
            f'void f{start + k}(void) {{ {body} }}'
            for k, body in enumerate(bodies[start:start + _FUNCTIONS])))
    files.append(folder / 'main.c')
    value = '' if by_expert else '.value'
    files[-1].write_text(
        '#include "all.h"\nTIME now; ALL all;\n'
        + ''.join(f'void f{k}(void);\n' for k in range(len(bodies)))
        + 'void scan(TIME t) { now = t; '
        + ''.join(f'f{k}();' for k in range(len(bodies))) + '}\n'
        + f'static BOOL image[{len(names)}];\n'
        + 'static BOOL *const places[] = {'
        + ','.join(f'image + {place}' if name in located else f'&all.{name}{value}'
                   for place, name in enumerate(names)) + '};\n'
        + 'static struct { BOOL **pointer, *value; } const located[] = {'
        + ','.join(f'{{&all.{name}.value, image + {place}}}'
                   for place, name in enumerate(names) if name in located) + '};\n'
        + 'void begin(void) { for (unsigned k = 0; k < sizeof located / sizeof *located; k++) '
          '*located[k].pointer = located[k].value; }\n'
        + 'void put(int k, BOOL v) { *places[k] = v; }\n'
        + 'BOOL get(int k) { return *places[k]; }\n')
    library = folder / 'peer.so'
    _build(files, library, flags)
    return Peer(library, {name: place for place, name in enumerate(names)})


def _functions(
    specs: Sequence[Spec], rung: Callable[[Spec], str], located: Set[str],
) -> list[str]:
    def access(found: re.Match[str]) -> str:
        is_located = found.group(2) in located
        return f'{found.group(1)}{"_LOCATED" if is_located else ""}({found.group(2)}'

    lines = [_VARIABLE.sub(r'all.\1', _ACCESS.sub(access, rung(spec))) for spec in specs]
    return ['\n'.join(lines[start:start + _RUNGS])
            for start in range(0, len(lines), _RUNGS)]


def _build(files: Sequence[Path], library: Path, flags: str) -> None:
    """Compile two files at a time, and link."""
    gcc = shutil.which('gcc')
    if gcc is None:
        raise SystemExit('gcc is not installed: there is no peer to compare with')
    running: list[subprocess.Popen[bytes]] = []
    for file in files:
        if len(running) >= 2 and running.pop(0).wait():
            raise SystemExit(f'gcc failed on {file}')
        running.append(subprocess.Popen(
            [gcc, *flags.split(), *_WITHOUT_STRINGS, '-w', '-fPIC', '-c', str(file),
             '-o', str(file.with_suffix('.o'))]))
    if any(process.wait() for process in running):
        raise SystemExit('gcc failed')
    subprocess.run(
        [gcc, '-shared', '-o', str(library), *(str(f.with_suffix('.o')) for f in files)],
        check=True)
