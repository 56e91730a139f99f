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
