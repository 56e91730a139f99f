# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The table of coded problems: one row a code, one page a code in docs/problems.

Codes never change their meaning and are never used again.  L01 files, L02 names and types,
L03 drawing, L04 compiling, L05 running, L06 ROS
and, from L0620, editing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum


class Severity(Enum):
    """How bad a problem is: only an error keeps a program from running."""

    ERROR = 'error'
    WARNING = 'warning'
    HINT = 'hint'


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """A row of the table; ``message`` and ``help`` may hold ``{placeholders}``."""

    code: str
    message: str
    help: str
    severity: Severity = Severity.ERROR


def _error(code: str, message: str, help: str) -> Problem:
    return Problem(code=code, message=message, help=help)


def _warning(code: str, message: str, help: str) -> Problem:
    return Problem(code=code, message=message, help=help, severity=Severity.WARNING)


_FILES = (
    _error('L0101', 'the file is not well-formed XML: {reason}',
           'mend the XML at this place; an XML editor shows it too'),
    _error('L0102', 'this is no ladder program: the root element is {root}',
           'a program starts with <ladder version="1" name="...">'),
    _error('L0103', 'unknown element <{element}> in <{parent}>', 'allowed here: {allowed}'),
    _error('L0104', 'unknown attribute {attribute} of <{element}>', 'allowed here: {allowed}'),
    _error('L0105', '<{element}> lacks its attribute {attribute}', 'add {attribute}="..."'),
    _error('L0106', 'attribute {attribute} of <{element}> has a bad value', '{expected}'),
    _error('L0107', 'the file is too large: {what}',
           'the limit is {limit}; split the program or make composites of what repeats'),
    _error('L0108', 'document types, entities and processing instructions are not allowed',
           'remove the <!DOCTYPE ...>, <!ENTITY ...> or <?...?>; programs are untrusted input'),
    _error('L0109', 'the file cannot be read: {reason}', 'check the path and the permissions'),
    _error('L0110', 'format version {version} is not known',
           'this release reads version {known}; update ladder_ros or save the program again'),
    _error('L0111', 'unexpected text in <{element}>', 'only <specification> holds text'),
    _error('L0112', '<{element}> appears more than once in <{parent}>',
           'keep one of them'),
    _error('L0113', '<{element}> stands in the wrong place in <{parent}>',
           'the order in it is: {order}'),
    _error('L0114', 'the task {name} never runs',
           'give it an interval, such as T#10ms, or the variable whose rise runs it: single'),
    _error('L0115', 'the import options cannot be used: {reason}',
           'write for instance {{"order": "position-kind", "stubs": true}}; orders: {orders}'),
    _error('L0116', '<{element}> cannot stand in {where}', '{expected}'),
    _error('L0120', 'this is no Structured Text: {what} (column {column})', '{expected}'),
    _error('L0121', 'the Structured Text is too large: {what}',
           'at most {limit}; split it, or put parts of it into variables or POUs of their own'),
    _error('L0122', 'code in C cannot run here',
           'write in Structured Text what the pragma {{...}} does'),
    _warning('L0130', 'the file departs from PLCopen TC6: {what}', 'it is read as {read}'),
    _warning('L0131', 'a wire comes from nothing: {source}: {reason}',
             'the wire is left out; draw it again in the editor'),
    _warning('L0132', 'the localId {id} is used twice in this drawing',
             'wires go to the first; draw the second again in the editor'),
    _error('L0133', '{what} names nothing', 'give it a variable in the editor'),
    _error('L0134', 'the project holds no POU', 'export it with its programs'),
    _error('L0135', 'the type {type} cannot be used: {reason}', 'correct the declaration'),
    _error('L0136', 'the initial value of {name} cannot be read: {reason}',
           "write a literal of the variable's type"),
    _warning('L0137', 'the address {address} of {name} is not understood',
             'it is left out; write an address such as %IX0.0, %QX1.7 or %MW10'),
    _warning('L0138', 'left out: {what}: {reason}', 'what uses it cannot run here'),
    _warning('L0139', 'a {type} has no instance name', 'it is called {name} here; name it'),
    _warning('L0140', '{name} is declared more than once, or without a name',
             'the first counts; rename or remove the other'),
    _warning('L0141', '{name} has the unknown type {type}',
             'it is taken for a function block that is not in the file'),
    _warning('L0142', 'the instance {instance} is of a program that is not there: {program}',
             'it is left out; correct the configuration'),
    _warning('L0143', 'no task runs the program {program}',
             'as nothing else runs, it is run; add an instance of it to a task'),
    _warning('L0144', 'the task {task} has no interval that can be read',
             'what it runs, runs in every scan; give it one such as T#20ms'),
    _warning('L0145', "the external variable {name} is nobody's global variable",
             'a global variable is made for it; declare it in the configuration'),
    _warning('L0146', 'the address {address} of {name} has not the size of {type}',
             'it is a name alone here, nothing overlaps; {type} has addresses such as {right}'),
    _error('L0150', 'this is no JSON: {reason}',
           'save the project again in OpenPLC Editor, or mend the text at this place'),
    _warning('L0151', 'the project departs from what OpenPLC Editor writes: {what}',
             'it is read as {read}'),
    _error('L0152', '{what} has no meaning: {reason}',
           'open the project in OpenPLC Editor, mend this there and save it again'),
    _error('L0153', '{name} is one POU of an OpenPLC Editor v4 project, which is not here',
           'give the folder that holds project.json, or a file in the folder pous beside it'),
)

_NAMES = (
    _error('L0201', 'the name {name} is used twice', 'rename one of the two; case does not count'),
    _error('L0202', '{name} is no legal name',
           'a name is letters, digits and single underscores, and starts with a letter or _'),
    _error('L0203', 'unknown variable {name}', 'declare it, or correct the name{hint}'),
    _error('L0204', '{name} is {actual}, but {expected} is needed here',
           'use a variable or literal of type {expected}'),
    _error('L0205', 'bad literal for {type}', '{reason}'),
    _error('L0206', 'unknown composite {name}', 'define it in <composites>{hint}'),
    _error('L0207', 'composite {name} contains itself', 'break the chain {chain}'),
    _error('L0208', 'unknown block type {name}', 'known blocks: {known}{hint}'),
    _error('L0209', '{owner} has no pin or parameter {pin}', 'it has {known}'),
    _error('L0210', '{owner} needs its pin or parameter {pin} connected',
           'bind a variable or a literal of type {type} to it'),
    _error('L0211', '{name} cannot be written', '{reason}'),
    _warning('L0212', '{name} is written by more than one coil',
             'the last one evaluated wins in each scan; use set and reset coils, or one coil'),
    _error('L0213', 'the instance {name} is used as {actual} and as {expected}',
           'give each block or composite an instance name of its own'),
    _error('L0215', 'unknown task {name}', 'declare it in <tasks>{hint}'),
    _error('L0216', '{name} {what}', '{reason}'),
    _error('L0218', 'pin {pin} needs exactly one of operand, source and row', 'keep one of them'),
    _error('L0219', 'the program has no body', 'add <body name="main"> with at least one rung'),
    _error('L0220', 'the types of {name} do not fit together',
           'its inputs and output must be of one type: {reason}'),
    _error('L0221', 'pin {pin} of {name} is connected twice', 'keep one of the connections'),
    _warning('L0242', 'nothing is known of the block {name}; {instance} is a stand-in for it',
             'its outputs are inputs of the program: map them to topics; pins: {pins}'),
    _warning('L0243', '{name} is not declared', 'it is taken as a local variable of type {type}'),
    _warning('L0244', 'nothing is wired to the pin {pin} of {owner}',
             'it is taken as the zero of its type, {type}; wire a value to it'),
    _warning('L0245', 'the body of {name} cannot run: {reason}; there is a stand-in for it',
             'the outputs of its instances are inputs of the program: map them to topics; '
             'pins: {pins}'),
    _error('L0240', 'the body of {name} cannot run: {reason}',
           'draw it as a ladder or function block diagram, or write it in Structured Text'),
    _warning('L0241', 'the body of {name} cannot run: {reason}; nothing uses it',
             'the rest of the program runs without it'),
    _warning('L0222', 'the instance {name} is called more than once',
             'it keeps one state for all its calls; give each call an instance of its own'),
    _error('L0224', 'the index {index} is outside of {name}', 'it goes from {low} to {high}'),
    _error('L0225', '{name} may not stand {where}', '{reason}'),
    _error('L0226', 'no network has the label {name}',
           'draw the label at the network to go on with, or correct the name{hint}'),
    _error('L0227', 'the pin {pin} of {owner} is a function block of the type {type}',
           'no copies are made of function blocks; give {owner} the values that it reads, or make '
           'the function block a global variable'),
)

_DRAWING = (
    _error('L0301', 'two components cover the same cell: {first} and {second}',
           'move one of them to a free cell'),
    _error('L0302', '{name} lies outside the power rails',
           'the rung is {width} columns wide: move it, or make the rung wider'),
    _error('L0303', 'the {end} end of {name} is connected to nothing',
           'draw a row to the next component or rail, or move the component'),
    _error('L0304', 'the parallel interface of {name} points {side} to nothing',
           'join it to a component or column in the next row, or {remedy}'),
    _error('L0305', 'nothing stands between the power rails', '{reason}'),
    _error('L0306', 'power cannot reach {name}', 'connect its left end to the left power rail'),
    _error('L0307', 'the data connections form a loop without a function block: {chain}',
           'break the loop, or put a function block into it'),
    _warning('L0308', 'power from {name} goes nowhere', 'end the branch with a coil or a block'),
    _error('L0310', '{source} is no data output in this drawing',
           'write the id of a block and one of its outputs, as in t1.ET{hint}'),
    _warning('L0311', '{name} is connected straight to the left power rail',
             'it is always on; put a contact before it if that is not meant'),
    _error('L0312', '{name} has no component in its row {row}',
           'a power pin lies in one of the rows the component covers'),
    _error('L0313', 'the power flow forms a loop: {chain}',
           'a relay loop has no meaning in one scan; break it'),
)

_COMPILING = (
    _error('L0401', 'the program grows too large when its composites are put in: {count}',
           'at most {limit}; composites nested in composites multiply'),
    _error('L0402', 'bad instruction list: {reason}', '{expected}'),
)

_RUNNING = (
    _error('L0501', 'the table of inputs cannot be read: {reason}', '{expected}'),
    _error('L0502', 'there is no variable {name} in the program', 'check the name{hint}'),
    _error('L0503', 'bad value for {name}: {reason}', '{expected}'),
    _error('L0504', 'unknown backend {name}', 'available here: {known}'),
    _error('L0505', 'the scan interval {value} cannot be used', '{reason}'),
    _error('L0506', 'the program stopped with a fault: {reason}', '{expected}'),
    _error('L0507', 'the file cannot be written: {reason}', 'check the path and the permissions'),
    _error('L0508', '{request} is not possible now: the controller is {state}', '{expected}'),
    _error('L0509', 'the program has no body or composite {name}', 'it has {known}'),
    _error('L0510', 'programs cannot be written as {form}', 'available here: {known}'),
    _error('L0511', '{what} cannot be written as {form}',
           'change that part of the program, or export it to another form'),
    _error('L0512', 'there is no rung {name} in {place}', 'it has {known}'),
    _error('L0513', 'the values cannot be read: {reason}',
           'give a message of ~/monitor, a JSON object of values by variable, or a CSV table as '
           '`ladder simulate` writes it'),
    _error('L0514', '{first} and {second} do not go together', '{expected}'),
    _error('L0520', '{request} is not possible: {reason}', '{expected}'),
    _error('L0521', 'the program was not compiled: {reason}', '{expected}'),
    _warning('L0522', '{name} was nowhere: the running program has no {places}',
             'correct was="..." or remove it; {name} starts with its initial value'),
    _error('L0523', 'the retained values cannot be read: {reason}', '{expected}'),
    _error('L0524', 'the retained values cannot be saved: {reason}', '{expected}'),
    _error('L0525', 'the task {name} took {took}, its watchdog allows {limit}',
           'make what it runs shorter, or raise its watchdog or sensitivity'),
    _error('L0526', 'the recording cannot be used: {reason}', '{expected}'),
    _error('L0527', 'a scan does not end: {name} has run for {took}',
           'look for loops that go on too long, and give the task a watchdog'),
    _warning('L0530', 'there is no native code: {reason}',
             'Python runs the program; install ladder_ros[native], or choose the backend python'),
)

_ROS = (
    _error('L0601', 'the I/O map names {name}, which is no variable of the program',
           'correct or remove the entry {parameter}{hint}'),
    _error('L0602', 'message type {type} does not fit {name}', '{expected}'),
    _error('L0603', '{topic} is no legal topic name', '{reason}'),
    _error('L0604', 'parameter {name} has a bad value', '{expected}'),
    _error('L0605', 'the program {name} may not be loaded', '{reason}'),
    _warning('L0606', 'unknown parameter {name}: it is ignored',
             'leave it if it is meant for another node, else correct the name{hint}'),
    _error('L0607', 'unknown I/O parameter {name}', 'an entry of the I/O map has {known}{hint}'),
    _error('L0608', 'the topic {topic} belongs to more than one variable',
           'give {name} another topic with io.{name}.topic'),
    _warning('L0609', 'the I/O map names {name}, which this program does not have',
             'the entry rests until a program with this variable is loaded'),
    _error('L0610', 'the program was not loaded in time: {reason}', '{expected}'),
    _error('L0611', 'the recording of topics cannot be used: {reason}', '{expected}'),
    _error('L0612', 'there is no message type {type}', '{expected}'),
    _error('L0613', 'the field {field} of {type} cannot be used: {reason}', '{hint}'),
    _error('L0614', 'the field {field} of {topic} belongs to more than one variable',
           'give {name} another field with io.{name}.field, or another topic'),
)

_EDITING = (
    _error('L0620', 'no drawing of rung {rung} was found that has its order of evaluation',
           'break the loop of data connections in it, or split the rung'),
    _error('L0621', 'there is no {what} {name}', 'known here: {known}{hint}'),
    _error('L0622', 'rung {rung} would become {width} columns wide',
           'the limit is {limit}: make a composite of a part of it, or split it with a variable'),
    _error('L0623', '{name} may not stand there: {reason}', '{remedy}'),
    _error('L0624', '{name} cannot be deleted: {reason}', 'every rung and branch has an output'),
    _error('L0625', 'the edit cannot be done: {reason}', '{expected}'),
    _error('L0626', '{name} cannot be edited: it is no ladder diagram on our grid',
           'draw it as a program of ladder_ros; Structured Text is edited as text'),
)

_REFACTORING = (
    _error('L0630', 'there is no {what}', 'there is {known}'),
    _error('L0631', '{what} cannot become a composite: {reason}',
           'choose more or less of the drawing, or change it so that this is not so'),
    _error('L0632', '{name} cannot be used as a name: {reason}', 'choose another name'),
    _error('L0633', 'the library {name} cannot be used: {reason}', '{expected}'),
    _error('L0634', '{name} cannot be drawn out: {reason}',
           'leave it as it is, or draw its contents here by hand'),
    _error('L0635', 'rung {rung} cannot be {what}: {reason}', 'change the drawing first'),
)

_PROVING = (
    _error('L0670', 'there is no solver: the Python package z3-solver is not installed',
            'install it: pip install z3-solver, or on Ubuntu apt install python3-z3'),
    _error('L0671', 'nothing to prove, or too much at once',
           'give a second program, or else properties with --never and --always'),
    _error('L0673', 'two programs are compared, {count} were given', 'write: ladder diff OLD NEW'),
    _error('L0672', 'the change is not made: {reason}',
           'prove and try the program before, or set change.require to report or nothing'),
)

PROBLEMS: Mapping[str, Problem] = {
    row.code: row
    for table in (
        _FILES, _NAMES, _DRAWING, _COMPILING, _RUNNING, _ROS, _EDITING, _REFACTORING, _PROVING)
    for row in table
}
"""Every problem by its code."""
