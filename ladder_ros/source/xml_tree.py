# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""An untrusted XML file as a tree of elements, each with its line.

Our own files are read bare: names as they stand, text in prose elements alone.  Files of other
tools are read ``foreign``: namespaces resolved, all text kept, processing instructions ignored.

Expat and not a tree library, because it says the true line of every element of files of any length
and because everything that can hurt can be stopped while it is being read: document types (hence
entities), processing instructions, deep nesting, many elements, long texts.  Nothing here opens
anything but the one file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import os
import re
import stat
from xml.parsers import expat

from ladder_ros.diagnostics import Diagnostic, LadderError, Location, problem, refusal_of
from ladder_ros.nouns import maker

MAX_BYTES = 128 * 1024 * 1024
MAX_DEPTH = 32
MAX_ELEMENTS = 2_000_000
MAX_TEXT = 65_536
MAX_DIAGNOSTICS = 100

_XML_SPACE = ' \t\r\n'
_PROSE = ('specification', 'st')
"""Elements of our own files that hold text."""
_SEPARATOR = ' '
"""Between a namespace and a local name; no namespace that expat passes on has a blank."""
_ENCODINGS = {
    'utf-8': ('utf-8', 'utf8', 'us-ascii', 'ascii'),
    'utf-16': ('utf-16', 'utf-16le', 'utf-16be'),
}
_DECLARATION = re.compile(r'<\?xml\s[^>]*?encoding\s*=\s*["\']([^"\'>]*)["\']')
_ENTITY = re.compile(r'&(?!(?:amp|lt|gt|quot|apos);)[^#\s&;"\'<>][^\s&;"\'<>]{0,40};')
_UNDEFINED_ENTITY = expat.errors.codes[expat.errors.XML_ERROR_UNDEFINED_ENTITY]
_NO_ELEMENT = expat.errors.codes[expat.errors.XML_ERROR_NO_ELEMENTS]
_LEFT_OPEN = (_NO_ELEMENT, expat.errors.codes[expat.errors.XML_ERROR_TAG_MISMATCH])


@dataclass(slots=True, kw_only=True)
class Element:
    """An element as it stands in the file.

    ``text`` is its character data; ``text_line`` is the line of the first that is not white
    space, or None.  ``namespace`` is known in foreign files only.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ''
    text_line: int | None = None
    namespace: str = ''


_element = maker(Element)


class TooManyProblemsError(Exception):
    """As many problems as anybody reads in one go have been found."""


class Findings:
    """The problems found in one file, at most MAX_DIAGNOSTICS of them."""

    def __init__(self) -> None:
        """Start with none."""
        self.diagnostics: list[Diagnostic] = []

    def add(self, diagnostic: Diagnostic) -> None:
        """Keep a diagnostic; raises TooManyProblemsError when it is the last that fits."""
        self.diagnostics.append(diagnostic)
        if len(self.diagnostics) >= MAX_DIAGNOSTICS:
            raise TooManyProblemsError

    def stop(self, diagnostic: Diagnostic) -> LadderError:
        """Return the error for a problem after which reading makes no sense."""
        return LadderError([*self.diagnostics, diagnostic])


def read_file(path: str | os.PathLike[str]) -> bytes:
    """Return the contents of a regular file of at most MAX_BYTES.

    Raises LadderError: L0109 if there is no such file or it is none that can be read to its end,
    L0107 if it is too large.
    """
    name = os.fspath(path)
    place = Location(file=name)
    try:
        # Opening a named pipe must not wait for somebody who writes to it.
        descriptor = os.open(name, os.O_RDONLY | getattr(os, 'O_NONBLOCK', 0))
    except OSError as error:
        raise LadderError.of('L0109', place, reason=refusal_of(error)) from None
    except ValueError as error:  # a NUL or a lone surrogate in the path
        raise LadderError.of('L0109', place, reason=str(error)) from None
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            what = 'a directory' if stat.S_ISDIR(status.st_mode) else 'no regular file'
            raise LadderError.of('L0109', place, reason=f'it is {what}')
        with open(descriptor, 'rb', closefd=False) as file:
            # Room for the most that may be is asked for only if the file has grown meanwhile.
            data = file.read(min(status.st_size, MAX_BYTES) + 1)
            if len(data) > status.st_size:
                data += file.read(MAX_BYTES + 1 - len(data))
    except OSError as error:
        raise LadderError.of('L0109', place, reason=refusal_of(error)) from None
    finally:
        os.close(descriptor)
    if len(data) > MAX_BYTES:
        raise too_large(place, 'bytes', MAX_BYTES)
    return data


def root_element(data: bytes) -> tuple[str, str]:
    """Return namespace and local name of the root element, or empty texts if there is none.

    Nothing is reported: whoever reads the file then says what is wrong with it.
    """
    found = ['', '']

    def start(tag: str, attributes: dict[str, str]) -> None:
        found[0], _, found[1] = tag.rpartition(_SEPARATOR)
        raise _FoundRootError

    try:
        text = _decode(data[:MAX_BYTES + 1], '')
        if _document_type(text) is not None:
            return '', ''
        parser = expat.ParserCreate(namespace_separator=_SEPARATOR)
        parser.StartElementHandler = start
        parser.Parse(text, True)
    except (_FoundRootError, LadderError, expat.ExpatError):
        pass
    return found[0], found[1]


class _FoundRootError(Exception):
    """Stops the parser at the first element."""


def parse_tree(
    data: bytes, file: str, findings: Findings, *, foreign: bool = False,
) -> Element:
    """Return the root element of an XML document.

    Processing instructions are added to ``findings`` (L0108).  Raises LadderError, with what was
    found before, where the document cannot be read any further: L0101, L0107, L0108.
    """
    place = Location(file=file)
    if len(data) > MAX_BYTES:
        raise findings.stop(too_large(place, 'bytes', MAX_BYTES).diagnostics[0])
    text = _decode(data, file)
    if (offset := _document_type(text)) is not None:
        line = text.count('\n', 0, offset) + 1
        raise LadderError.of(
            'L0108', Location(file=file, line=line), text[offset:offset + 60].split('\n')[0])
    builder = _ForeignBuilder(file, findings) if foreign else _Builder(file, findings)
    reading = builder.reading
    try:
        reading.parser.Parse(text, True)
    except expat.ExpatError as error:
        raise findings.stop(_malformed(reading, error, text)) from None
    root, reading.root = reading.root, None  # it need not wait for the collector afterwards
    assert root is not None, 'expat accepts no document without a root'
    return root


def too_large(place: Location, what: str, limit: int) -> LadderError:
    """Return the error for more than there may be of something (L0107)."""
    return LadderError.of(
        'L0107', place, what=f'more than {limit} {what}', limit=f'{limit} {what}')


def _decode(data: bytes, file: str) -> str:
    """Return the text of the file, which is UTF-8 (ASCII is) or UTF-16, whatever it says."""
    place = Location(file=file)
    if data.startswith((b'\xff\xfe\0\0', b'\0\0\xfe\xff', b'<\0\0\0', b'\0\0\0<')):
        raise _encoding(place, 'UTF-32')
    codec = 'utf-8'
    if data.startswith((b'\xff\xfe', b'\xfe\xff')):
        codec = 'utf-16'
    elif data.startswith((b'<\0', b'\0<')):
        codec = 'utf-16-le' if data.startswith(b'<') else 'utf-16-be'
    try:
        text = data.decode(codec).removeprefix('\ufeff')
    except UnicodeDecodeError as error:
        before = data[:error.start].decode(codec, 'ignore')
        raise LadderError.of(
            'L0101', Location(file=file, line=before.count('\n') + 1),
            f'byte {data[error.start]:#04x} at offset {error.start}',
            reason=f'this is no {codec[:6].upper().rstrip("-")} text',
            help='save the file as UTF-8') from None
    declared = _DECLARATION.match(text[:1000])
    if declared and declared.group(1).lower() not in _ENCODINGS[codec[:6].rstrip('-')]:
        raise _encoding(place, declared.group(1))
    return text


def _encoding(place: Location, name: str) -> LadderError:
    return LadderError.of(
        'L0101', place, f'encoding {name}', reason='its encoding cannot be read',
        help='save the file as UTF-8 (or UTF-16)')


def _document_type(text: str) -> int | None:
    """Return where the document type declaration starts, or None.

    It is looked for before parsing: what it declares must never get to the parser, which would
    go on to expand entities to the end of its input after a handler has failed.
    """
    if '<!DOCTYPE' not in text:
        return None
    position = 0
    while True:
        while position < len(text) and text[position] in _XML_SPACE:
            position += 1
        if text.startswith('<!DOCTYPE', position):
            return position
        end = -1
        if text.startswith('<!--', position):
            end = text.find('-->', position + 4)
        elif text.startswith('<?', position):
            end = text.find('?>', position + 2) - 1
        if end < 0:
            return None  # the root, where document types are errors of form, or no XML
        position = end + 3


def _malformed(reading: _Reading, error: expat.ExpatError, text: str) -> Diagnostic:
    """Make the diagnostic of what expat says; name the element that is open there."""
    offset = max(0, reading.parser.ErrorByteIndex)
    place = Location(file=reading.file, line=error.lineno)
    around = text.encode()
    if error.code == _UNDEFINED_ENTITY:  # the offset is the start of the tag it is in
        entity = _ENTITY.search(around[offset:].decode('utf-8', 'ignore'))
        return problem(
            'L0101', place, entity.group() if entity else '', reason='undefined entity',
            help='write & as &amp; (known are &amp; &lt; &gt; &quot; &apos; and &#number;)')
    before = around[max(0, offset - 30):offset].decode('utf-8', 'ignore').rpartition('\n')[2]
    after = around[offset:offset + 30].decode('utf-8', 'ignore').partition('\n')[0]
    reason = f'{expat.ErrorString(error.code) or "unknown error"}, column {error.offset + 1}'
    if error.code == _NO_ELEMENT:
        reason = 'it ends too early'
    related = [
        (Location(file=reading.file, line=element.line), f'<{element.tag[:40]}> is still open')
        for element in reading.open[-1:] if error.code in _LEFT_OPEN]
    return problem('L0101', place, (before + after).strip(), reason=reason, related=related)


class _Reading:
    """What reading any document needs: the parser, the open elements, the limits."""

    def __init__(self, file: str, findings: Findings, separator: str | None) -> None:
        self.file = file
        self.findings = findings
        self.root: Element | None = None
        self.open: list[Element] = []
        self.count = 0
        parser = expat.ParserCreate(namespace_separator=separator)
        parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
        parser.StartDoctypeDeclHandler = self.document_type
        self.parser = parser

    def here(self) -> Location:
        return Location(file=self.file, line=self.parser.CurrentLineNumber)

    def stop(self, what: str, limit: int) -> LadderError:
        return self.findings.stop(too_large(self.here(), what, limit).diagnostics[0])

    def enter(self, tag: str, attributes: dict[str, str], namespace: str = '') -> None:
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise self.stop('elements', MAX_ELEMENTS)
        opened = self.open
        if len(opened) >= MAX_DEPTH:
            raise self.stop('levels of elements', MAX_DEPTH)
        element = _element(
            tag=tag, attributes=attributes, line=self.parser.CurrentLineNumber,
            namespace=namespace)
        if opened:
            opened[-1].children.append(element)
        else:
            self.root = element
        opened.append(element)

    def document_type(self, name: str, system: str | None, public: str | None,
                      internal: bool) -> None:
        raise self.findings.stop(problem('L0108', self.here(), f'<!DOCTYPE {name} ...>'))


class _Builder:
    """Builds the tree of one of our own files."""

    def __init__(self, file: str, findings: Findings) -> None:
        self.reading = _Reading(file, findings, None)
        self.pieces: list[str] = []
        self.text_length = 0
        parser = self.reading.parser
        parser.StartElementHandler = self.reading.enter
        parser.EndElementHandler = self.end
        parser.CharacterDataHandler = self.characters
        parser.ProcessingInstructionHandler = self.instruction

    def end(self, tag: str) -> None:
        element = self.reading.open.pop()
        if self.pieces:
            element.text = ''.join(self.pieces)
            self.pieces.clear()
            self.text_length = 0

    def characters(self, text: str) -> None:
        element = self.reading.open[-1]
        if element.tag in _PROSE:
            self.text_length += len(text)
            if self.text_length > MAX_TEXT:
                raise self.reading.stop('characters of text', MAX_TEXT)
            self.pieces.append(text)
        elif element.text_line is None and (bare := text.strip(_XML_SPACE)):
            element.text = bare[:100]
            element.text_line = self.reading.parser.CurrentLineNumber

    def instruction(self, target: str, data: str) -> None:
        self.reading.findings.add(
            problem('L0108', self.reading.here(), f'<?{target} {data}?>'))


class _ForeignBuilder:
    """Builds the tree of a file of another tool: local names, and the text of every element."""

    def __init__(self, file: str, findings: Findings) -> None:
        self.reading = _Reading(file, findings, _SEPARATOR)
        self.pieces: list[list[str]] = []
        parser = self.reading.parser
        parser.StartElementHandler = self.start
        parser.EndElementHandler = self.end
        parser.CharacterDataHandler = self.characters

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        namespace, _, name = tag.rpartition(_SEPARATOR)
        self.reading.enter(name, attributes, namespace)
        self.pieces.append([])

    def end(self, tag: str) -> None:
        self.reading.open.pop().text = ''.join(self.pieces.pop())

    def characters(self, text: str) -> None:
        element = self.reading.open[-1]
        if element.text_line is None and text.strip(_XML_SPACE):
            element.text_line = self.reading.parser.CurrentLineNumber
        self.pieces[-1].append(text)
