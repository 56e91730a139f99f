# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables 1 and 2 of paper 1 on our three-floor elevator, by hand and by itself; clones at scale.

Also where the bytes of the files are, and what composites save against the same program with each
of them drawn out where it is used, comments included.

python benchmarks/refactoring.py [RUNS]
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
import re
import shutil
import sys
import tempfile
import time

from ladder_ros import refactoring
from ladder_ros.refactoring import Goal, Measured
from ladder_ros.resources import find_resource

WAYS = ('flat', 'by hand', 'by hand, library', 'auto', 'auto, library', 'auto for bytes')
KINDS = ('texts', 'declarations', 'parameters', 'definitions', 'uses', 'other rungs')
RUNGS = 10_000


def prepared(folder: Path) -> list[Path]:
    """Write the six programs into a folder."""
    paths = [folder / f'{way.replace(", ", "_").replace(" ", "_")}.xml' for way in WAYS]
    flat, hand, hand_library, auto, auto_library, fewest = paths
    shutil.copy(find_resource('programs', 'elevator_3_floor_flat.xml'), flat)
    shutil.copy(find_resource('programs', 'elevator_3_floor.xml'), hand)
    for path, goal in ((auto, Goal.COMPONENTS), (fewest, Goal.BYTES)):
        path.write_text(refactoring.auto(flat, goal=goal).text)
        path.write_text(refactoring.forget(path).text)
    for path, smaller, name in ((hand, hand_library, 'hand'), (auto, auto_library, 'auto')):
        library = f'{name}_composites.xml'
        (folder / library).write_text(refactoring.export_composites(path).text)
        smaller.write_text(refactoring.use_library(path, library).text)
    return paths


def table_1(hand: Measured) -> None:
    print('table 1                 components  parameters  connections')
    for name in ('FloorIndicator', 'UpDownContactor'):
        one = next(c for c in hand.composites if c.name == name)
        pairs = zip(one.members.to_json().values(), one.instance.to_json().values(), strict=True)
        print(f'{name:24}' + '  '.join(f'{a:>4} -> {b}' for a, b in pairs))


def table_2(found: list[Measured]) -> None:
    flat = found[0]
    print(f'\n{"table 2":20}{"components":>18}{"file size":>20}{"load time":>20}'
          f'{"time to show":>20}')
    print(f'{"paper 1":20}{"30.12%":>18}{"24.59%":>20}{"":>20}{"25.86%":>20}')
    for way, one in zip(WAYS, found, strict=True):
        assert one.time is not None and flat.time is not None
        cells = [
            (f'{one.counts.components}', one.counts.components / flat.counts.components),
            (f'{one.size} B', one.size / flat.size),
            (f'{one.time.load * 1e3:.2f} ms', one.time.load / flat.time.load),
            (f'{one.time.show * 1e3:.2f} ms', one.time.show / flat.time.show)]
        widths = (18, 20, 20, 20)
        print(f'{way:20}' + ''.join(
            f'{f"{text} {1 - share:7.2%}":>{width}}'
            for (text, share), width in zip(cells, widths, strict=True)))


def drawn_out(path: Path) -> int:
    """Return the size of a program after all its composites have been drawn out."""
    flat = path.with_stem(f'{path.stem}_drawn_out')
    shutil.copy(path, flat)
    for name in re.findall('<composite name="([^"]*)"', path.read_text()):
        flat.write_text(refactoring.inline(flat, composite=name).text)
    flat.write_text(refactoring.forget(flat).text)
    return flat.stat().st_size


def bytes_by_kind(path: Path) -> dict[str, int]:
    """Return how many bytes of a program stand for what; ``texts`` are all comments and prose."""
    found = Counter[str]()
    section = ''
    for line in path.read_text().splitlines(keepends=True):
        tag = line.strip().split()[0].strip('<>/')
        section = tag if tag in ('composite', 'variables', 'body') else section
        texts = sum(map(len, re.findall(' comment="[^"]*"', line)))
        if tag == 'specification' or tag.startswith('specification>'):
            texts = len(line)
        found['texts'] += texts
        kind = 'definitions' if section == 'composite' else 'other rungs'
        if tag == 'parameter':
            kind = 'parameters'
        elif tag == 'instance':
            kind = 'uses'
        elif section != 'composite' and tag in ('?xml', 'ladder', 'variables', 'variable',
                                                'tasks', 'task', 'use', 'body'):
            kind = 'declarations'
        found[kind] += len(line) - texts
    assert sum(found.values()) == path.stat().st_size
    return {kind: found[kind] for kind in KINDS}


def table_of_bytes(paths: list[Path]) -> None:
    print(f'\n{"bytes":20}' + ''.join(f'{kind:>14}' for kind in KINDS) + f'{"saved*":>10}')
    for way, path in zip(WAYS, paths, strict=True):
        share = '' if 'library' in way else f'{1 - path.stat().st_size / drawn_out(path):.2%}'
        print(f'{way:20}' + ''.join(f'{size:>14}' for size in bytes_by_kind(path).values())
              + f'{share:>10}')
    print('* against the same program with its composites drawn out where they are used')


def large_program(rungs: int) -> str:
    """Return a program in which three drawings stand again and again with other names."""
    lines = ['<ladder version="1" name="large"><variables>']
    drawn = []
    names: set[str] = set()
    for number in range(rungs):
        kind, group = number % 5, number // 5
        contacts = {
            0: f'in{group} rising|hold{group} nc', 1: f'memo{group} no|in{group + 7} nc',
            2: f'hold{group} no|in{group} no|memo{group + 3} nc', 3: f'in{number} no',
            4: f'memo{group} nc|hold{group} no|in{number % 97} falling'}[kind].split('|')
        coil = ('memo', 'hold', 'out', 'late', 'end')[kind] + str(group)
        parts = []
        for x, text in enumerate(contacts):
            name, way = text.split()
            names.add(name)
            parts.append(f'<contact id="c{x}" x="{x}" y="0" operand="{name}" kind="{way}"/>')
        names.add(coil)
        x = len(contacts)
        drawn.append(f'<rung id="{number + 1}" width="{x + 1}">{"".join(parts)}'
                     f'<coil id="k" x="{x}" y="0" operand="{coil}"/></rung>')
    lines += [f'<variable name="{name}" type="BOOL"/>' for name in sorted(names)]
    return ''.join([*lines, '</variables><body name="main">', *drawn, '</body></ladder>'])


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else refactoring.DEFAULT_RUNS
    with tempfile.TemporaryDirectory() as folder:
        paths = prepared(Path(folder))
        found = list(refactoring.measure_files(paths, runs=runs))
        table_1(found[1])
        table_2(found)
        table_of_bytes(paths)
        large = Path(folder) / 'large.xml'
        large.write_text(large_program(RUNGS))
        start = time.process_time()
        refactoring.measure_files([large], runs=0)
        checked = time.process_time() - start
        start = time.process_time()
        repeats = refactoring.find(large)
        print(f'\n{RUNGS} rungs: {len(repeats)} repeats found in '
              f'{time.process_time() - start - checked:.1f} s after {checked:.1f} s of compiling '
              '(CPU time)')


if __name__ == '__main__':
    main()
