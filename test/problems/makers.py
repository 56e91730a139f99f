# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Problems that no command gives: each made by what raises it, from the files of its page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import count
from pathlib import Path
import sys
import threading
from typing import Any
from unittest import mock

from runtime.handmade import executable, Variables
from support.documents import ROOT
import yaml

from ladder_ros.background.process import CompilerProcess
from ladder_ros.compiler import llvm_machine
from ladder_ros.compiler.il_text import parse_il
from ladder_ros.compiler.stages import analyse
from ladder_ros.compiler.symbols import Resolved
from ladder_ros.compiler.wiring import End, Net, Part, Wiring
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.compiling import compile_file
from ladder_ros.converting import export
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.diagnostics import LadderError, render
from ladder_ros.model.component import Contact, Placement
from ladder_ros.model.program import Rung
from ladder_ros.proving import prove_never
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.runtime.retain_store import load_retained, Retained, save_retained
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle
from ladder_ros.runtime.simulation import Simulation
from ladder_ros.session import Requirement, Session
from ladder_ros.simulating import replay
from ladder_ros.source.xml_to_model import parse_program


def _error_of(action: Callable[[], object]) -> str:
    try:
        action()
    except LadderError as error:
        return str(error)
    raise AssertionError('nothing was raised')


def power_loop(_folder: Path) -> str:
    """Give two contacts each other's power."""
    contacts = [
        Contact(id=name, placement=Placement(x=x, y=0), operand=name)
        for x, name in enumerate(('c1', 'c2'))]
    nets = tuple(Net(index=index, x=index, first=0, last=0) for index in (0, 1))
    parts = tuple(
        Part(component=contact, left=(End(pin='', net=index),),
             right=(End(pin='', net=1 - index),))
        for index, contact in enumerate(contacts))
    rung = Rung(id='1', width=2, components=tuple(contacts))
    wiring = Wiring(rung=rung, nets=nets, parts=parts, lines=())
    return render(build_aov(wiring, dict.fromkeys(('c1', 'c2'), Resolved()))[1])


def bad_instruction_list(folder: Path) -> str:
    """Read an instruction list."""
    text = (folder / 'program.il').read_text(encoding='utf-8')
    return _error_of(lambda: parse_il(text, 'program.il'))


def fault(_folder: Path) -> str:
    """Simulate an executable whose body raises."""
    def fail(variables: Variables, now: int) -> None:
        raise RuntimeError('a broken body')

    broken = executable('n:INT:output', {'main': fail})
    simulation = Simulation(
        executable=broken, slots=broken.slots, scans=1, interval_ns=1_000_000, inputs=None)
    return _error_of(lambda: list(simulation))


def wrong_state(folder: Path) -> str:
    """Reset a program that runs."""
    with Session() as session:
        session.open(folder / 'program.xml')
        session.start()
        return _error_of(session.reset)


def unknown_form(folder: Path) -> str:
    """Write a program in a form that does not exist."""
    return _error_of(lambda: export(folder / 'program.xml', 'pdf')).replace(f'{folder}/', '')


def no_test(folder: Path) -> str:
    """Accept when no program is on test."""
    with Session(clock=SimulatedClock()) as session:
        session.open(folder / 'program.xml')
        return _error_of(session.accept)


def too_slow_to_compile(folder: Path) -> str:
    """Compile in no time."""
    compiler = CompilerProcess()
    data = (folder / 'program.xml').read_bytes()
    try:
        return _error_of(lambda: compiler.compile(
            data, 'program.xml', backend='python', timeout=0))
    finally:
        compiler.close()


def nowhere(folder: Path) -> str:
    """Preflight a program that looks for what is not there."""
    with Session(clock=SimulatedClock()) as session:
        session.open(folder / 'program.xml')
        found = session.preflight(folder / 'renamed.xml')
        return render(found.comparison.warnings).replace(f'{folder}/', '')


def damaged_store(folder: Path) -> str:
    """Read retained values from a file that holds none."""
    store = folder / 'retained'
    store.write_text('something else', encoding='utf-8')
    return _error_of(lambda: load_retained(str(store))).replace(f'{folder}/', '')


def missing_folder(folder: Path) -> str:
    """Save retained values where nothing can be saved."""
    values = Retained(program='example', hash='', saved='', values={})
    return _error_of(lambda: save_retained(
        str(folder / 'missing' / 'retained'), values)).replace(f'{folder}/', '')


def watchdog(folder: Path) -> str:
    """Run a task on a clock that moves by 3 ms whenever it is looked at."""
    times = count(0, 3_000_000)
    cycle = ScanCycle(compile_file(folder / 'program.xml').executable, lambda: next(times))
    try:
        cycle.scan(0)
    except ProgramFault as fault:
        return str(fault.__cause__)
    raise AssertionError('no watchdog has tripped')


def endless(folder: Path) -> str:
    """Tell of a task without a watchdog as after a little more than five seconds."""
    cycle = ScanCycle(compile_file(folder / 'program.xml').executable)
    cycle.scan(0)
    limit = cycle.limit()
    return str(limit.error(limit.longest + 250_000_000))


def no_recording(folder: Path) -> str:
    """Replay a program file."""
    return _error_of(lambda: replay(folder / 'program.xml', [])).replace(f'{folder}/', '')


def no_llvm(_folder: Path) -> str:
    """Compile for the backend native as if llvmlite were not installed."""
    caches = (llvm_machine.why_missing, llvm_machine._machine, llvm_machine._llvm)
    for cached in caches:
        cached.cache_clear()
    try:
        with mock.patch.dict(sys.modules, {'llvmlite': None, 'llvmlite.binding': None}):
            loaded = compile_file(ROOT / 'programs' / 'start_stop.xml', 'native')
    finally:
        for cached in caches:
            cached.cache_clear()
    assert loaded.executable.backend == 'python'
    return render(loaded.diagnostics).replace(f'{ROOT / "programs"}/', '')
def no_solver(folder: Path) -> str:
    """Prove something where the solver is not installed."""
    with mock.patch('ladder_ros.refactor.equivalence.to_z3.z3', None):
        return _error_of(lambda: prove_never(folder / 'program.xml', 'motor'))


def not_proved(folder: Path) -> str:
    """Change to another program where only an equivalent one is allowed."""
    old, new = folder / 'program.xml', folder / 'negated.xml'
    new.write_text(old.read_text(encoding='utf-8').replace(
        'operand="motor"/>', 'kind="negated" operand="motor"/>'), encoding='utf-8')
    with Session(background=False) as session:
        session.open(old)
        session.assurance.requirement = Requirement.EQUIVALENT
        loaded = session.prepare(new)
        while session.assurance.report(session.loaded, loaded).answer == 'pending':
            pass
        return _error_of(lambda: session.commit(loaded)).replace(f'{folder}/', '')


# -- the node -------------------------------------------------------------------------------------

def overrides(folder: Path) -> dict[str, Any]:
    """Return the parameters of the page's YAML file as the client library hands them over."""
    document = yaml.safe_load((folder / 'cell.yaml').read_text(encoding='utf-8'))
    flat: dict[str, Any] = {}

    def flatten(prefix: str, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            if isinstance(value, dict):
                flatten(f'{prefix}{name}.', value)
            else:
                flat[prefix + name] = value

    flatten('', document['plc_node']['ros__parameters'])
    return flat


def unknown_parameter(folder: Path) -> str:
    """Read the parameters."""
    from ladder_ros.ros.parameters import read_settings
    return render(read_settings(overrides(folder))[1])


def dropped_variable(folder: Path) -> str:
    """Resolve the I/O map for the program without its variable motor."""
    from ladder_ros.ros.io_map import resolve_io
    from ladder_ros.ros.message_types import installed_fields
    from ladder_ros.ros.parameters import read_settings
    file = folder / 'program.xml'
    text = file.read_text(encoding='utf-8')
    file.write_text(text.replace('"motor"', '"gate"'), encoding='utf-8')
    changed = compile_file(file).executable
    entries = read_settings(overrides(folder))[0].io
    found = resolve_io(changed, entries, lambda topic: topic, installed_fields, strict=False)
    return render(found.warnings)


def busy_compiler(folder: Path) -> str:
    """Reload while a node is still compiling."""
    import rclpy

    from ladder_ros.ros.lifecycle import make_node
    from ladder_ros.ros.parameters import read_settings
    from ladder_ros.ros.plc import Plc
    context = rclpy.Context()
    rclpy.init(context=context)
    node = make_node('plc_node', context=context)
    compiled = threading.Event()
    settings = read_settings({'program': str(folder / 'program.xml'), 'retain_file': ''})[0]
    plc = Plc(node, settings)
    try:
        plc.open()
        plc.cell.loader.worker = threading.Thread(target=compiled.wait)
        plc.cell.loader.worker.start()
        return _error_of(plc.reload).replace(f'{folder}/', '')
    finally:
        compiled.set()
        plc.close()
        node.destroy_node()
        rclpy.shutdown(context=context)


def impossible_order(folder: Path) -> str:
    """Draw a graph whose order of evaluation is another than its drawing's."""
    program = parse_program((folder / 'program.xml').read_bytes(), 'program.xml')
    aov = analyse(program).graphs['body main'][0]
    backwards = replace(aov, symbols=aov.symbols[::-1])
    return _error_of(lambda: draw_rung(backwards, rung_id='1'))


MAKERS: Mapping[str, Callable[[Path], str]] = {
    'L0313': power_loop,
    'L0402': bad_instruction_list,
    'L0506': fault,
    'L0508': wrong_state,
    'L0510': unknown_form,
    'L0520': no_test,
    'L0521': too_slow_to_compile,
    'L0522': nowhere,
    'L0523': damaged_store,
    'L0524': missing_folder,
    'L0525': watchdog,
    'L0526': no_recording,
    'L0530': no_llvm,
    'L0527': endless,
    'L0606': unknown_parameter,
    'L0609': dropped_variable,
    'L0610': busy_compiler,
    'L0620': impossible_order,
    'L0670': no_solver,
    'L0672': not_proved,
}
"""By the problem's code: what gives the text of the page, from the folder with its files."""
