# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Event-driven scans: only the chunks of a body are executed whose inputs have changed.

A chunk that reads the values it read last time, and none of whose timers runs, would write what
is there already: it can be left out.  A copy of the state (the *shadow*) tells what has changed
since: first what came from outside, then, after each chunk that was executed, what it wrote.
Readers of a changed byte are marked; those further down are executed in this scan, the others in
the next one, as in a scan of everything.  So all values are equal after each scan, whatever is
left out.

Where much changes, following the changes costs more than it saves: when more than a fifth of the
chunks were executed, the next scans execute everything, more of them each time in a row.  The last
of these compares the state before and after it: what a chunk has read differs from what is there
now only if somebody wrote it since, and that shows, unless others write it too.

The kernel is the same for all programs, which give it tables.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
import ctypes

from ladder_ros.compiler.llvm_memory import Activity
from ladder_ros.compiler.native_state import NativeLayout, SIZE

_HEADER = 64


class EventTables:
    """The kernel's view of a body: who reads what, and what each chunk writes."""

    def __init__(self, chunks: Sequence[Activity], layout: NativeLayout) -> None:
        """Work the tables out."""
        self.count, self.size = len(chunks), layout.size
        self.bitmap = (self.count + 63) // 64
        shadow = (_HEADER + 8 * self.bitmap + 63) // 64 * 64
        self.area = shadow + self.size
        """How many bytes the kernel keeps for a state, zero at first."""
        readers, writers = _users(chunks)
        first = array('i', [0]) * self.size
        middle, end = array('i', first), array('i', first)
        rows, shared = array('i'), array('Q', [0]) * self.bitmap
        for index, offset in enumerate(layout.offsets):
            if offset < 0 or not (index in readers or index in writers):
                continue
            own, written = readers.get(index, []), writers.get(index, [])
            if len(written) > 1:  # what one writes another may have to write again
                for writer in written:
                    shared[writer // 64] |= 1 << writer % 64
                own, written = sorted({*own, *written}), []
            start = len(rows)
            rows.extend(own)
            between = len(rows)
            rows.extend(writer for writer in written if writer not in own)
            for place in range(offset, offset + SIZE[layout.types[index]]):
                first[place], middle[place], end[place] = start, between, len(rows)
        words, timers = array('i'), array('i')
        word_starts, timer_starts = array('i', [0]), array('i', [0])
        for chunk in chunks:
            words.extend(sorted({layout.offsets[slot] // 8 for slot in chunk.writes}))
            word_starts.append(len(words))
            timers.extend(sorted(layout.offsets[slot] for slot in chunk.timers))
            timer_starts.append(len(timers))
        large = max((offset + 8 for offset, type_ in zip(
            layout.offsets, layout.types, strict=True) if offset >= 0 and SIZE[type_] == 8),
            default=0)
        self._arrays = [
            word_starts, first, middle, end, rows, timer_starts, timers, words, shared]
        self._numbers = [self.count, self.size, self.bitmap, shadow, large]

    def bind(self, functions: Sequence[int], full: int) -> ctypes.Array[ctypes.c_int64]:
        """Return the tables with the addresses of the chunks, and of a scan of everything."""
        addresses = array('q', functions)
        kept = [addresses, *self._arrays]
        places = [block.buffer_info()[0] for block in kept]
        table = (ctypes.c_int64 * (len(self._numbers) + 1 + len(places)))(
            *self._numbers, full, *places)
        table.kept = kept  # type: ignore[attr-defined]
        return table


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
"""The kernel's function: (state, now, area, tables) to how to go on."""

_NUMBERS = ('count', 'size', 'words', 'shadow_at', 'large')
_ADDRESSES = ('full_f', 'functions', 'word_starts', 'first', 'middle', 'end', 'rows',
              'timer_starts', 'timers', 'written', 'shared')
"""What stands in the tables by its name in the kernel, as :meth:`EventTables.bind` orders it."""


def _loads(*names: str) -> str:
    """Return what loads things from the tables."""
    fields = (*_NUMBERS, *_ADDRESSES)
    return ''.join(
        f'  %{name}_p = getelementptr i64, ptr %t, i64 {fields.index(name)}\n'
        f'  %{name} = load {"i64" if name in _NUMBERS else "ptr"}, ptr %{name}_p\n'
        for name in names)


_MARK = """
define internal void @mark(ptr %t, ptr %bitmap, i64 %word, i64 %changed, i64 %last) {
entry:
""" + _loads('large', 'first') + """\
  %end_p = getelementptr i64, ptr %t, i64 %last
  %ends = load ptr, ptr %end_p
""" + _loads('rows') + """\
  %base = shl i64 %word, 3
  %is_large = icmp ult i64 %base, %large
  %start = select i1 %is_large, i64 1, i64 %changed
  br label %bytes
bytes:
  %rest = phi i64 [ %start, %entry ], [ %left, %row_done ]
  %bit = call i64 @llvm.cttz.i64(i64 %rest, i1 false)
  %shift = and i64 %bit, 56
  %byte = lshr i64 %shift, 3
  %mask = shl i64 255, %shift
  %keep = xor i64 %mask, -1
  %left = and i64 %rest, %keep
  %offset = add i64 %base, %byte
  %from_p = getelementptr i32, ptr %first, i64 %offset
  %from = load i32, ptr %from_p
  %to_p = getelementptr i32, ptr %ends, i64 %offset
  %to = load i32, ptr %to_p
  br label %row
row:
  %j = phi i32 [ %from, %bytes ], [ %next, %set ]
  %more = icmp slt i32 %j, %to
  br i1 %more, label %set, label %row_done
set:
  %chunk_p = getelementptr i32, ptr %rows, i32 %j
  %chunk = load i32, ptr %chunk_p
  %chunk64 = zext i32 %chunk to i64
  %index = lshr i64 %chunk64, 6
  %place = and i64 %chunk64, 63
  %one = shl i64 1, %place
  %dirty_p = getelementptr i64, ptr %bitmap, i64 %index
  %dirty = load i64, ptr %dirty_p
  %marked = or i64 %dirty, %one
  store i64 %marked, ptr %dirty_p
  %next = add i32 %j, 1
  br label %row
row_done:
  %is_over = icmp eq i64 %left, 0
  br i1 %is_over, label %done, label %bytes
done:
  ret void
}
"""

_COMPARE = """
define internal void @compare(ptr %s, ptr %a, ptr %t, i64 %last) {
entry:
""" + _loads('size', 'shadow_at') + """\
  %shadow = getelementptr i8, ptr %a, i64 %shadow_at
  %bitmap = getelementptr i8, ptr %a, i64 64
  br label %compare
compare:
  %at = phi i64 [ 0, %entry ], [ %at_next, %compared ]
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
  br i1 %differs, label %words32, label %compared
words32:
  %k = phi i64 [ 0, %compare ], [ %k_next, %word_done ]
  %k_byte = shl i64 %k, 3
  %k_at = add i64 %at, %k_byte
  %k_mine_p = getelementptr i8, ptr %s, i64 %k_at
  %k_mine = load i64, ptr %k_mine_p
  %k_old_p = getelementptr i8, ptr %shadow, i64 %k_at
  %k_old = load i64, ptr %k_old_p
  %k_x = xor i64 %k_mine, %k_old
  %k_differs = icmp ne i64 %k_x, 0
  br i1 %k_differs, label %word_changed, label %word_done
word_changed:
  store i64 %k_mine, ptr %k_old_p
  %k_word = lshr i64 %k_at, 3
  call void @mark(ptr %t, ptr %bitmap, i64 %k_word, i64 %k_x, i64 %last)
  br label %word_done
word_done:
  %k_next = add i64 %k, 1
  %k_more = icmp ult i64 %k_next, 32
  br i1 %k_more, label %words32, label %compared
compared:
  %at_next = add i64 %at, 256
  %at_more = icmp ult i64 %at_next, %size
  br i1 %at_more, label %compare, label %done
done:
  ret void
}
"""

_RESYNC = """
define internal i8 @resync(ptr %s, i64 %now, ptr %a, ptr %t) {
entry:
""" + _loads('count', 'size', 'words') + """\
  %bytes = shl i64 %words, 3
""" + _loads('shadow_at') + """\
  %shadow = getelementptr i8, ptr %a, i64 %shadow_at
  %bitmap = getelementptr i8, ptr %a, i64 64
  %valid_p = getelementptr i64, ptr %a, i64 2
""" + _loads('full_f', 'timer_starts', 'timers', 'shared') + """\
  call void @llvm.memcpy.p0.p0.i64(ptr %shadow, ptr %s, i64 %size, i1 false)
  %r = call i8 %full_f(ptr %s, i64 %now)
  %left = icmp ne i8 %r, 0
  br i1 %left, label %stop, label %marks
stop:
  ret i8 %r
marks:
  call void @llvm.memcpy.p0.p0.i64(ptr %bitmap, ptr %shared, i64 %bytes, i1 false)
  call void @compare(ptr %s, ptr %a, ptr %t, i64 9)
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
  %dirty_p = getelementptr i64, ptr %bitmap, i64 %w
  %dirty = load i64, ptr %dirty_p
  %marked = or i64 %dirty, %bit
  store i64 %marked, ptr %dirty_p
  %k_next = add i32 %k, 1
  br label %timer
chunk_done:
  %more = icmp ult i64 %c_next, %count
  br i1 %more, label %chunk, label %done
done:
  ret i8 0
}
"""

_SCAN = """
define i8 @event_scan(ptr %s, i64 %now, ptr %a, ptr %t) {
entry:
  %full_left = load i64, ptr %a
  %valid_p = getelementptr i64, ptr %a, i64 2
  %valid = load i64, ptr %valid_p
  %is_valid = icmp ne i64 %valid, 0
  br i1 %is_valid, label %event, label %unknown
unknown:
  %is_full = icmp ne i64 %full_left, 0
  br i1 %is_full, label %full, label %last
full:
  %full_less = sub i64 %full_left, 1
  store i64 %full_less, ptr %a
""" + _loads('full_f') + """\
  %full_r = call i8 %full_f(ptr %s, i64 %now)
  ret i8 %full_r
last:
  %last_r = call i8 @resync(ptr %s, i64 %now, ptr %a, ptr %t)
  ret i8 %last_r
event:
  call void @compare(ptr %s, ptr %a, ptr %t, i64 10)
""" + _loads('count', 'words', 'shadow_at') + """\
  %shadow = getelementptr i8, ptr %a, i64 %shadow_at
  %bitmap = getelementptr i8, ptr %a, i64 64
""" + _loads('functions', 'word_starts', 'timer_starts', 'timers', 'written') + """\
  br label %word
word:
  %w = phi i64 [ 0, %event ], [ %w_next, %word_end ]
  %executed_w = phi i64 [ 0, %event ], [ %executed, %word_end ]
  %dirty_p = getelementptr i64, ptr %bitmap, i64 %w
  %w_base = shl i64 %w, 6
  br label %look
look:
  %executed = phi i64 [ %executed_w, %word ], [ %executed_next, %chunk_done ]
  %todo = phi i64 [ -1, %word ], [ %above, %chunk_done ]
  %dirty = load i64, ptr %dirty_p
  %pending = and i64 %dirty, %todo
  %none = icmp eq i64 %pending, 0
  br i1 %none, label %word_end, label %chunk
chunk:
  %b = call i64 @llvm.cttz.i64(i64 %pending, i1 true)
  %bit = shl i64 1, %b
  %bit_off = xor i64 %bit, -1
  %cleared = and i64 %dirty, %bit_off
  store i64 %cleared, ptr %dirty_p
  %above = shl i64 -2, %b
  %c = add i64 %w_base, %b
  %executed_next = add i64 %executed, 1
  %f_p = getelementptr ptr, ptr %functions, i64 %c
  %f = load ptr, ptr %f_p
  %r = call i8 %f(ptr %s, i64 %now)
  %failed = icmp ne i8 %r, 0
  br i1 %failed, label %stop, label %changes
stop:
  store i64 0, ptr %valid_p
  ret i8 %r
changes:
  %j_p = getelementptr i32, ptr %word_starts, i64 %c
  %j_first = load i32, ptr %j_p
  %c_next = add i64 %c, 1
  %j_end_p = getelementptr i32, ptr %word_starts, i64 %c_next
  %j_end = load i32, ptr %j_end_p
  br label %change
change:
  %j = phi i32 [ %j_first, %changes ], [ %j_next, %same ]
  %j_more = icmp slt i32 %j, %j_end
  br i1 %j_more, label %look_at, label %timing
look_at:
  %at_p = getelementptr i32, ptr %written, i32 %j
  %at = load i32, ptr %at_p
  %at64 = zext i32 %at to i64
  %mine_p = getelementptr i64, ptr %s, i64 %at64
  %mine = load i64, ptr %mine_p
  %old_p = getelementptr i64, ptr %shadow, i64 %at64
  %old = load i64, ptr %old_p
  %x = xor i64 %mine, %old
  %differs = icmp ne i64 %x, 0
  br i1 %differs, label %changed, label %same
changed:
  store i64 %mine, ptr %old_p
  call void @mark(ptr %t, ptr %bitmap, i64 %at64, i64 %x, i64 9)
  br label %same
same:
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
  %running = phi i8 [ 0, %timing ], [ %running_next, %timer_look ]
  %k_more = icmp slt i32 %k, %k_end
  br i1 %k_more, label %timer_look, label %timers_done
timer_look:
  %o_p = getelementptr i32, ptr %timers, i32 %k
  %o = load i32, ptr %o_p
  %o64 = zext i32 %o to i64
  %flag_p = getelementptr i8, ptr %s, i64 %o64
  %flag = load i8, ptr %flag_p
  %running_next = or i8 %running, %flag
  %k_next = add i32 %k, 1
  br label %timer
timers_done:
  %runs = icmp ne i8 %running, 0
  br i1 %runs, label %again, label %chunk_done
again:
  %again_old = load i64, ptr %dirty_p
  %again_new = or i64 %again_old, %bit
  store i64 %again_new, ptr %dirty_p
  br label %chunk_done
chunk_done:
  br label %look
word_end:
  %w_next = add i64 %w, 1
  %w_more = icmp ult i64 %w_next, %words
  br i1 %w_more, label %word, label %end
end:
  %executed_p = getelementptr i64, ptr %a, i64 3
  store i64 %executed, ptr %executed_p
  %back_p = getelementptr i64, ptr %a, i64 1
  %back = load i64, ptr %back_p
  %executed5 = mul i64 %executed, 5
  %much = icmp ugt i64 %executed5, %count
  br i1 %much, label %back_off, label %go_on
back_off:
  %back2 = shl i64 %back, 1
  %back_least = call i64 @llvm.umax.i64(i64 %back2, i64 4)
  %back_most = call i64 @llvm.umin.i64(i64 %back_least, i64 256)
  store i64 %back_most, ptr %back_p
  store i64 %back_most, ptr %a
  store i64 0, ptr %valid_p
  ret i8 0
go_on:
  %back_half = lshr i64 %back, 1
  store i64 %back_half, ptr %back_p
  ret i8 0
}

declare i64 @llvm.cttz.i64(i64, i1)
declare i64 @llvm.umax.i64(i64, i64)
declare i64 @llvm.umin.i64(i64, i64)
declare i64 @llvm.vector.reduce.or.v8i64(<8 x i64>)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
"""

KERNEL = _MARK + _COMPARE + _RESYNC + _SCAN
"""The kernel as a module of LLVM's intermediate language.

Tables, 8 bytes each: 0 chunks, 1 bytes of the state, 2 words of the bitmap, 3 where the shadow is
in the area, 4 bytes of the slots of 8 bytes, 5 the scan of everything, 6 the chunks' functions, 7
where each chunk's written words begin, 8 first, 9 middle and 10 end of each byte's row, 11 the
rows, 12 where each chunk's timers begin, 13 the timers, 14 the written
words, 15 the chunks that write what others write too.  A row lists who reads a byte, then who else
must be told if it came from outside.

Area: scans of everything that are left, the length of their last series, whether shadow and bitmap
are valid, chunks executed in the last scan; from byte 64 the bitmap, then the shadow.
"""
