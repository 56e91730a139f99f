# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The style sheet of the page: light, dark, and on paper."""

from __future__ import annotations

PAGE_STYLE = """
:root { color-scheme: light dark }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; padding: 0 1.5em; max-width: 75em;
  color: #1f2328; background: #ffffff }
h1 { margin-bottom: 0.2em }
h2 { margin-top: 2em; border-bottom: 1px solid #d1d9e0 }
small, .quiet { color: #59636e; font-weight: normal }
a { color: #0550ae; text-decoration: none }
a:hover { text-decoration: underline }
dl { display: grid; grid-template-columns: max-content auto; gap: 0.1em 1.2em }
dt { color: #59636e }
dd { margin: 0; overflow-wrap: anywhere }
table { border-collapse: collapse; width: 100%; margin: 1em 0; font-size: 14px }
th, td { text-align: left; vertical-align: top; padding: 0.25em 0.7em 0.25em 0;
  border-bottom: 1px solid #d1d9e0; overflow-wrap: break-word }
th { color: #59636e; font-weight: 600 }
figure { margin: 0.6em 0; overflow-x: auto }
pre { overflow-x: auto }
.error { color: #cf222e }
.warning { color: #8a5a00 }
:target { outline: 3px solid #bf8700; outline-offset: 2px }
@media screen and (prefers-color-scheme: dark) {
body { color: #e6edf3; background: #0d1117 }
h2, th, td { border-color: #30363d }
small, .quiet, dt, th { color: #9198a1 }
a { color: #79b8ff }
.error { color: #ff7b72 }
.warning { color: #e3b341 }
}
@media print {
body { max-width: none; margin: 0; padding: 0; font-size: 11px }
nav { display: none }
a { color: inherit }
h2, thead { break-after: avoid }
figure, tr { break-inside: avoid }
figure { overflow: visible }
figure svg { max-width: 100%; height: auto }
}""".strip()

DIFFERENCE_STYLE = """
body.difference { max-width: none }
.names, .sides { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 1fr);
  gap: 0 1.5em }
.names { margin-bottom: 0.3em }
.difference thead th:first-child { width: 2em }
.wide .sides { grid-template-columns: minmax(0, 1fr) }
section.rung { margin: 1em 0; border-left: 4px solid #d1d9e0; padding-left: 0.8em }
section.rung h3 { margin: 0; font-size: 15px }
section.rung ul { list-style: none; margin: 0.2em 0; padding: 0 }
.sign { display: inline-block; min-width: 1.3em; text-align: center; font-weight: bold;
  border: 1px solid #59636e; color: #1f2328 }
.legend .sign:not(:first-child) { margin-left: 1.2em }
.added { background: #c8f0d0 }
.removed { background: #ffd3d0 }
.changed, .renamed { background: #fff0b3 }
.moved { background: #cfe3ff }
section.rung { background: none }
section.added { border-color: #1a7f37 }
section.removed { border-color: #cf222e }
section.changed { border-color: #bf8700 }
section.moved { border-color: #0550ae }
details { margin: 0.6em 0; color: #59636e }
summary { cursor: pointer }
.texts { table-layout: fixed; width: 100% }
.texts td { border: none; padding: 0 0.5em; overflow-wrap: anywhere }
.texts code { white-space: pre-wrap; font-size: 13px }
@media screen and (prefers-color-scheme: dark) {
.sign { color: #e6edf3; border-color: #9198a1 }
.added { background: #12442a }
.removed { background: #5c1f22 }
.changed, .renamed { background: #4d3d0a }
.moved { background: #163760 }
section.rung { background: none }
details { color: #9198a1 }
}
@media print {
.sign, .added, .removed, .changed, .moved { print-color-adjust: exact }
section.rung { break-inside: avoid }
}""".strip()
"""What a page about two programs adds."""
