# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Event-driven scans: only the chunks of a body are executed whose inputs have changed.

A chunk that reads the values it read last time, and none of whose timers runs, would write what
is there already: it can be left out.  A copy of the state (the *shadow*) tells what has changed
since: first what came from outside, then, after each chunk that was executed, what it wrote.
Readers of a changed byte are marked; those further down are executed in this scan, the others in
the next one, as in a scan of everything.  So all values are equal after each scan, whatever is
left out.

What came from outside is mostly inputs, which lie at the beginning of the state: only these are
compared, unless somebody else has written the state meanwhile.  Who was last to write more than
inputs signs it (see `native_state`): the kernel with its area, all others with nothing.

Where nothing but a timer calls for a chunk, its *tick* is tried instead (see `llvm_ticks`), which
only lets time go on, and says if more than that would happen.

Where much changes, following the changes costs more than it saves: when about a fifth of the
chunks were executed, the next scans execute everything, more of them each time in a row.  The last
of these compares the state before and after it: what a chunk has read differs from what is there
now only if somebody wrote it since, and that shows, unless others write it too.

The kernel is the same for all programs, which give it tables.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence, Set
import ctypes
from itertools import count

from ladder_ros.compiler.llvm_memory import Activity
from ladder_ros.compiler.native_state import NativeLayout, SIGNATURE, SIZE

_HEADER = 64
_WINDOW = 32
"""Bytes that are looked at in one step for what a chunk has written."""

_numbers = count(1)


class BoundTables:
    """The tables with addresses of functions, at ``address``; ``number`` is no other's ever."""

    def __init__(self, numbers: Sequence[int], arrays: Sequence[array[int]], area: int) -> None:
        """Lay them out; ``area`` bytes are kept for each state."""
        self._arrays = arrays
        places = [block.buffer_info()[0] for block in arrays]
        self._table = (ctypes.c_int64 * (len(numbers) + len(places)))(*numbers, *places)
        self.address = ctypes.addressof(self._table)
        self.area = area
        self.number = next(_numbers)


class EventTables:
    """The kernel's view of a body: who reads what, and what each chunk writes."""

    def __init__(
        self, chunks: Sequence[Activity], layout: NativeLayout, own_times: Set[int],
    ) -> None:
        """Work the tables out; ``own_times`` are slots that matter while their timer runs only."""
        self._count, self._size = len(chunks), layout.size
        self._bitmap = (self._count + 63) // 64
        self._shadow = (_HEADER + 16 * self._bitmap + 63) // 64 * 64
        self._outside = layout.outside
        readers, writers = _users(chunks)
        rows = _Rows()
        own, outer = (array('i', [0]) * self._size for _ in range(2))
        shared = array('Q', [0]) * self._bitmap
        for index, offset in enumerate(layout.offsets):
            if offset < 0 or not (index in readers or index in writers):
                continue
            reading, writing = readers.get(index, []), writers.get(index, [])
            if len(writing) > 1:  # what one writes another may have to write again
                for writer in writing:
                    shared[writer // 64] |= 1 << writer % 64
                reading = [*reading, *writing]
            for place in range(offset, offset + SIZE[layout.types[index]]):
                own[place] = rows.of(reading)
                outer[place] = rows.of([*reading, *writing])
        windows, timers = array('i'), array('i')
        window_starts, timer_starts = array('i', [0]), array('i', [0])
        for chunk in chunks:
            windows.extend(_windows(
                [layout.offsets[slot] for slot in chunk.writes - own_times], self._size))
            window_starts.append(len(windows))
            timers.extend(sorted(layout.offsets[slot] for slot in chunk.timers))
            timer_starts.append(len(timers))
        self._arrays = [window_starts, windows, own, outer, rows.pairs, timer_starts, timers,
                        shared]

    def bind(self, full: int, chunks: int, ticks: int) -> BoundTables:
        """Return the tables with addresses: of a scan of everything, and of tables of functions.

        Those are the chunks and their ticks.
        """
        numbers = [self._count, self._size, self._bitmap, self._shadow, self._outside, full,
                   chunks, ticks]
        return BoundTables(numbers, self._arrays, self._shadow + self._size)


class _Rows:
    """Sets of chunks, as pairs of numbers.

    A pair is a word of the bitmap, times two, plus one if there is more of the set in the next
    pair; then the bits of that word.
    """

    def __init__(self) -> None:
        self.pairs = array('Q', [0, 0])
        self._known: dict[tuple[int, ...], int] = {(): 0}

    def of(self, chunks: Sequence[int]) -> int:
        """Return the number of the first pair of a set."""
        key = tuple(sorted(set(chunks)))
        found = self._known.get(key)
        if found is not None:
            return found
        words: dict[int, int] = {}
        for chunk in key:
            words[chunk // 64] = words.get(chunk // 64, 0) | 1 << chunk % 64
        start = self._known[key] = len(self.pairs) // 2
        for left, (word, bits) in zip(range(len(words) - 1, -1, -1), words.items(), strict=True):
            self.pairs.extend((2 * word + (left > 0), bits))
        return start


def _windows(offsets: Sequence[int], size: int) -> list[int]:
    """Return where windows begin that have all of these bytes in them, few of them."""
    found: list[int] = []
    for offset in sorted(offsets):
        if not found or offset >= found[-1] + _WINDOW:
            found.append(min(offset // 8 * 8, size - _WINDOW))
    return found


def _users(chunks: Sequence[Activity]) -> tuple[
        Mapping[int, list[int]], Mapping[int, list[int]]]:
    """Return the chunks that read, and those that write, each slot."""
    readers: dict[int, list[int]] = {}
    writers: dict[int, list[int]] = {}
    for number, chunk in enumerate(chunks):
        for users, slots in ((readers, chunk.reads), (writers, chunk.writes)):
            for slot in slots:
                users.setdefault(slot, []).append(number)
    return readers, writers


SYMBOL = 'event_scan'
"""The kernel's function: the address of an area to how to go on."""
NO_TICK = 'event_no_tick'
"""The tick of a chunk that has none: it is to be executed."""

_NUMBERS = ('count', 'size', 'words', 'shadow_at', 'outside')
_ADDRESSES = ('full', 'functions', 'ticks', 'starts', 'windows', 'own', 'outer', 'rows',
              'timer_starts', 'timers', 'shared')
"""What stands in the tables by its name in the kernel, as :meth:`EventTables.bind` orders it."""


def _loads(*names: str) -> str:
    """Return what loads things from the tables."""
    fields = (*_NUMBERS, *_ADDRESSES)
    return ''.join(
        f'  %{name}_t = getelementptr i64, ptr %t, i64 {fields.index(name)}\n'
        f'  %{name} = load {"i64" if name in _NUMBERS else "ptr"}, ptr %{name}_t\n'
        for name in names)


_FOLLOW = """
define internal void @follow(ptr %s, ptr %shadow, ptr %dirty, ptr %index, ptr %rows, i64 %at) {
entry:
  %now_p = getelementptr i8, ptr %s, i64 %at
  %now = load <32 x i8>, ptr %now_p, align 8
  %old_p = getelementptr i8, ptr %shadow, i64 %at
  %old = load <32 x i8>, ptr %old_p, align 8
  %differ = icmp ne <32 x i8> %now, %old
  %bytes = bitcast <32 x i1> %differ to i32
  %is_same = icmp eq i32 %bytes, 0
  br i1 %is_same, label %done, label %changed
changed:
  store <32 x i8> %now, ptr %old_p, align 8
  br label %byte
byte:
  %rest = phi i32 [ %bytes, %changed ], [ %left, %byte_done ]
  %last_row = phi i32 [ 0, %changed ], [ %row, %byte_done ]
  %k = call i32 @llvm.cttz.i32(i32 %rest, i1 true)
  %less = sub i32 %rest, 1
  %left = and i32 %rest, %less
  %k64 = zext i32 %k to i64
  %place = add i64 %at, %k64
  %row_p = getelementptr i32, ptr %index, i64 %place
  %row = load i32, ptr %row_p
  %is_done = icmp eq i32 %row, %last_row
  br i1 %is_done, label %byte_done, label %mark
mark:
  %r = phi i32 [ %row, %byte ], [ %r_next, %mark ]
  %r64 = zext i32 %r to i64
  %pair_p = getelementptr [2 x i64], ptr %rows, i64 %r64
  %where = load i64, ptr %pair_p
  %which_p = getelementptr i64, ptr %pair_p, i64 1
  %which = load i64, ptr %which_p
  %word = lshr i64 %where, 1
  %dirty_p = getelementptr i64, ptr %dirty, i64 %word
  %before = load i64, ptr %dirty_p
  %after = or i64 %before, %which
  store i64 %after, ptr %dirty_p
  %r_next = add i32 %r, 1
  %more = trunc i64 %where to i1
  br i1 %more, label %mark, label %byte_done
byte_done:
  %is_over = icmp eq i32 %left, 0
  br i1 %is_over, label %done, label %byte
done:
  ret void
}
"""

_COMPARE = """
define internal void @compare(
    ptr %s, ptr %shadow, ptr %dirty, ptr %index, ptr %rows, i64 %size) {
entry:
  br label %test
test:
  %at = phi i64 [ 0, %entry ], [ %at_next, %compared ]
  %more = icmp ult i64 %at, %size
  br i1 %more, label %block, label %done
block:
""" + ''.join(f"""\
  %at{n} = add i64 %at, {64 * n}
  %mine{n}_p = getelementptr i8, ptr %s, i64 %at{n}
  %mine{n} = load <8 x i64>, ptr %mine{n}_p, align 8
  %old{n}_p = getelementptr i8, ptr %shadow, i64 %at{n}
  %old{n} = load <8 x i64>, ptr %old{n}_p, align 8
  %x{n} = xor <8 x i64> %mine{n}, %old{n}
""" for n in range(4)) + """\
  %x01 = or <8 x i64> %x0, %x1
  %x23 = or <8 x i64> %x2, %x3
  %x = or <8 x i64> %x01, %x23
  %any = call i64 @llvm.vector.reduce.or.v8i64(<8 x i64> %x)
  %differs = icmp ne i64 %any, 0
  br i1 %differs, label %window, label %compared
window:
  %k = phi i64 [ 0, %block ], [ %k_next, %window ]
  %k_at = add i64 %at, %k
  call void @follow(ptr %s, ptr %shadow, ptr %dirty, ptr %index, ptr %rows, i64 %k_at)
  %k_next = add i64 %k, 32
  %k_more = icmp ult i64 %k_next, 256
  br i1 %k_more, label %window, label %compared
compared:
  %at_next = add i64 %at, 256
  br label %test
done:
  ret void
}
"""


_RESYNC = """
define internal i8 @resync(ptr %a, i64 %now, ptr %s, ptr %t) {
entry:
""" + _loads(
    'count', 'size', 'words', 'shadow_at', 'full', 'own', 'rows', 'timer_starts', 'timers',
    'shared',
) + """\
  %shadow = getelementptr i8, ptr %a, i64 %shadow_at
  %dirty = getelementptr i8, ptr %a, i64 64
  %ticking = getelementptr i64, ptr %dirty, i64 %words
  %valid_p = getelementptr i64, ptr %a, i64 5
  %bytes = shl i64 %words, 3
  call void @llvm.memcpy.p0.p0.i64(ptr %shadow, ptr %s, i64 %size, i1 false)
  %r = call i8 %full(ptr %s, i64 %now)
  %left = icmp ne i8 %r, 0
  br i1 %left, label %stop, label %marks
stop:
  ret i8 %r
marks:
  call void @llvm.memcpy.p0.p0.i64(ptr %dirty, ptr %shared, i64 %bytes, i1 false)
  call void @llvm.memset.p0.i64(ptr %ticking, i8 0, i64 %bytes, i1 false)
  call void @compare(ptr %s, ptr %shadow, ptr %dirty, ptr %own, ptr %rows, i64 %size)
  store i64 1, ptr %valid_p
  br label %chunk
chunk:
  %c = phi i64 [ 0, %marks ], [ %c_next, %chunk_done ]
  %c_next = add i64 %c, 1
  %k_p = getelementptr i32, ptr %timer_starts, i64 %c
  %k_first = load i32, ptr %k_p
  %k_end_p = getelementptr i32, ptr %timer_starts, i64 %c_next
  %k_end = load i32, ptr %k_end_p
  br label %timer
timer:
  %k = phi i32 [ %k_first, %chunk ], [ %k_next, %look ]
  %k_more = icmp slt i32 %k, %k_end
  br i1 %k_more, label %look, label %chunk_done
look:
  %o_p = getelementptr i32, ptr %timers, i32 %k
  %o = load i32, ptr %o_p
  %flag_p = getelementptr i8, ptr %s, i32 %o
  %flag = load i8, ptr %flag_p
  %flag64 = zext i8 %flag to i64
  %place = and i64 %c, 63
  %bit = shl i64 %flag64, %place
  %w = lshr i64 %c, 6
  %ticking_p = getelementptr i64, ptr %ticking, i64 %w
  %before = load i64, ptr %ticking_p
  %after = or i64 %before, %bit
  store i64 %after, ptr %ticking_p
  %k_next = add i32 %k, 1
  br label %timer
chunk_done:
  %more = icmp ult i64 %c_next, %count
  br i1 %more, label %chunk, label %done
done:
  ret i8 0
}
"""

_SCAN = f"""
define i8 @{NO_TICK}(ptr %s, i64 %now) {{
  ret i8 1
}}

define i8 @{SYMBOL}(ptr %a) {{
entry:
  %s = load ptr, ptr %a
  %t_p = getelementptr i64, ptr %a, i64 1
  %t = load ptr, ptr %t_p
  %now_p = getelementptr i64, ptr %a, i64 2
  %now = load i64, ptr %now_p
  %signature_p = getelementptr i8, ptr %s, i64 {SIGNATURE}
  %signature = load ptr, ptr %signature_p
  store ptr %a, ptr %signature_p
  %full_left_p = getelementptr i64, ptr %a, i64 3
  %valid_p = getelementptr i64, ptr %a, i64 5
  %valid = load i64, ptr %valid_p
  %is_valid = icmp ne i64 %valid, 0
  br i1 %is_valid, label %event, label %unknown
unknown:
  %full_left = load i64, ptr %full_left_p
  %is_full = icmp ne i64 %full_left, 0
  br i1 %is_full, label %everything, label %last
everything:
  %full_less = sub i64 %full_left, 1
  store i64 %full_less, ptr %full_left_p
""" + _loads('full') + """\
  %full_r = call i8 %full(ptr %s, i64 %now)
  ret i8 %full_r
last:
  %last_r = call i8 @resync(ptr %a, i64 %now, ptr %s, ptr %t)
  ret i8 %last_r
event:
""" + _loads(
    'count', 'size', 'words', 'shadow_at', 'outside', 'functions', 'ticks', 'starts', 'windows',
    'own', 'outer', 'rows', 'timer_starts', 'timers',
) + """\
  %shadow = getelementptr i8, ptr %a, i64 %shadow_at
  %dirty = getelementptr i8, ptr %a, i64 64
  %ticking = getelementptr i64, ptr %dirty, i64 %words
  %is_ours = icmp eq ptr %signature, %a
  %compared = select i1 %is_ours, i64 %outside, i64 %size
  call void @compare(ptr %s, ptr %shadow, ptr %dirty, ptr %outer, ptr %rows, i64 %compared)
  br label %word
word:
  %w = phi i64 [ 0, %event ], [ %w_next, %word_end ]
  %cost_w = phi i64 [ 0, %event ], [ %cost, %word_end ]
  %dirty_p = getelementptr i64, ptr %dirty, i64 %w
  %ticking_p = getelementptr i64, ptr %ticking, i64 %w
  %w_base = shl i64 %w, 6
  br label %look
look:
  %cost = phi i64 [ %cost_w, %word ], [ %cost_tick, %tick ], [ %cost_chunk, %chunk_done ]
  %todo = phi i64 [ -1, %word ], [ %above, %tick ], [ %above, %chunk_done ]
  %marked = load i64, ptr %dirty_p
  %running = load i64, ptr %ticking_p
  %either = or i64 %marked, %running
  %pending = and i64 %either, %todo
  %none = icmp eq i64 %pending, 0
  br i1 %none, label %word_end, label %chunk
chunk:
  %b = call i64 @llvm.cttz.i64(i64 %pending, i1 true)
  %bit = shl i64 1, %b
  %bit_off = xor i64 %bit, -1
  %above = shl i64 -2, %b
  %c = add i64 %w_base, %b
  %own_mark = and i64 %marked, %bit
  %is_marked = icmp ne i64 %own_mark, 0
  br i1 %is_marked, label %execute, label %tick
tick:
  %cost_tick = add i64 %cost, 1
  %tick_p = getelementptr ptr, ptr %ticks, i64 %c
  %tick_f = load ptr, ptr %tick_p
  %tick_r = call i8 %tick_f(ptr %s, i64 %now)
  %is_enough = icmp eq i8 %tick_r, 0
  br i1 %is_enough, label %look, label %execute
execute:
  %cost_chunk = add i64 %cost, 4
  %cleared = and i64 %marked, %bit_off
  store i64 %cleared, ptr %dirty_p
  %f_p = getelementptr ptr, ptr %functions, i64 %c
  %f = load ptr, ptr %f_p
  %r = call i8 %f(ptr %s, i64 %now)
  %failed = icmp ne i8 %r, 0
  br i1 %failed, label %stop, label %changes
stop:
  store i64 0, ptr %valid_p
  ret i8 %r
changes:
  %j_p = getelementptr i32, ptr %starts, i64 %c
  %j_first = load i32, ptr %j_p
  %c_next = add i64 %c, 1
  %j_end_p = getelementptr i32, ptr %starts, i64 %c_next
  %j_end = load i32, ptr %j_end_p
  br label %change
change:
  %j = phi i32 [ %j_first, %changes ], [ %j_next, %look_at ]
  %j_more = icmp slt i32 %j, %j_end
  br i1 %j_more, label %look_at, label %timing
look_at:
  %at_p = getelementptr i32, ptr %windows, i32 %j
  %at = load i32, ptr %at_p
  %at64 = zext i32 %at to i64
  call void @follow(ptr %s, ptr %shadow, ptr %dirty, ptr %own, ptr %rows, i64 %at64)
  %j_next = add i32 %j, 1
  br label %change
timing:
  %k_p = getelementptr i32, ptr %timer_starts, i64 %c
  %k_first = load i32, ptr %k_p
  %k_end_p = getelementptr i32, ptr %timer_starts, i64 %c_next
  %k_end = load i32, ptr %k_end_p
  br label %timer
timer:
  %k = phi i32 [ %k_first, %timing ], [ %k_next, %timer_look ]
  %flags = phi i8 [ 0, %timing ], [ %flags_next, %timer_look ]
  %k_more = icmp slt i32 %k, %k_end
  br i1 %k_more, label %timer_look, label %chunk_done
timer_look:
  %o_p = getelementptr i32, ptr %timers, i32 %k
  %o = load i32, ptr %o_p
  %o64 = zext i32 %o to i64
  %flag_p = getelementptr i8, ptr %s, i64 %o64
  %flag = load i8, ptr %flag_p
  %flags_next = or i8 %flags, %flag
  %k_next = add i32 %k, 1
  br label %timer
chunk_done:
  %flag64 = zext i8 %flags to i64
  %own_tick = shl i64 %flag64, %b
  %others = and i64 %running, %bit_off
  %running_now = or i64 %others, %own_tick
  store i64 %running_now, ptr %ticking_p
  br label %look
word_end:
  %w_next = add i64 %w, 1
  %w_more = icmp ult i64 %w_next, %words
  br i1 %w_more, label %word, label %end
end:
  %cost_p = getelementptr i64, ptr %a, i64 6
  store i64 %cost, ptr %cost_p
  %back_p = getelementptr i64, ptr %a, i64 4
  %back = load i64, ptr %back_p
  %cost5 = mul i64 %cost, 5
  %count4 = shl i64 %count, 2
  %much = icmp ugt i64 %cost5, %count4
  br i1 %much, label %back_off, label %go_on
back_off:
  %back2 = shl i64 %back, 1
  %back_least = call i64 @llvm.umax.i64(i64 %back2, i64 4)
  %back_most = call i64 @llvm.umin.i64(i64 %back_least, i64 256)
  store i64 %back_most, ptr %back_p
  store i64 %back_most, ptr %full_left_p
  store i64 0, ptr %valid_p
  ret i8 0
go_on:
  %back_half = lshr i64 %back, 1
  store i64 %back_half, ptr %back_p
  ret i8 0
}

declare i32 @llvm.cttz.i32(i32, i1)
declare i64 @llvm.cttz.i64(i64, i1)
declare i64 @llvm.umax.i64(i64, i64)
declare i64 @llvm.umin.i64(i64, i64)
declare i64 @llvm.vector.reduce.or.v8i64(<8 x i64>)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
"""

KERNEL = _FOLLOW + _COMPARE + _RESYNC + _SCAN
"""The kernel as a module of LLVM's intermediate language.

Tables, 8 bytes each, numbers first: of chunks, bytes of the state, words of a bitmap; where the
shadow is in the area; bytes at the state's beginning that only come from outside.  Then addresses:
the scan of everything, the chunks' functions, their ticks; where each chunk's windows begin, the
windows; each byte's row of chunks that read it, its row of those that must be told if it came from
outside, the rows; where each chunk's timers begin, the timers; the chunks that write what others
write too.

Area: 0 the state, 1 the tables, 2 the time, 3 scans of everything that are left, 4 the length of
their last series, 5 whether shadow and bitmaps are valid, 6 four for each chunk that was executed
in the last scan and one for each tick; from byte 64 the bitmaps of chunks to be executed, and of
those with timers that run, then the shadow.
"""
