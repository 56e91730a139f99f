# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs that the tests of the command line write to files."""

from __future__ import annotations

SEAL_IN = """\
<?xml version="1.0" encoding="UTF-8"?>
<ladder version="1" name="seal_in">
  <variables>
    <variable name="start" class="input" type="BOOL"/>
    <variable name="stop" class="input" type="BOOL"/>
    <variable name="motor" class="output" type="BOOL"/>
    <variable name="ran" class="output" type="TIME"/>
  </variables>
  <body name="main">
    <rung id="1" width="5" comment="seal-in – läuft">
      <contact id="c1" x="0" y="0" operand="start" down="right"/>
      <contact id="c2" x="0" y="1" operand="motor" up="right"/>
      <contact id="c3" x="1" y="0" operand="stop" kind="nc"/>
      <row id="r1" x="2" y="0" width="2"/>
      <coil id="k1" x="4" y="0" operand="motor"/>
    </rung>
    <rung id="2" width="4">
      <contact id="c1" x="0" y="0" operand="motor"/>
      <block id="b1" x="1" y="0" width="2" height="2" type="TON" instance="t1">
        <input pin="PT" operand="T#30ms"/>
        <output pin="ET" operand="ran"/>
      </block>
      <row id="r1" x="3" y="0"/>
    </rung>
  </body>
</ladder>
"""

TWO_COILS = """\
<ladder version="1" name="two_coils">
  <variables>
    <variable name="a" class="input" type="BOOL"/>
    <variable name="x" class="output" type="BOOL"/>
  </variables>
  <body name="main">
    <rung id="1" width="2">
      <contact id="c1" x="0" y="0" operand="a"/>
      <coil id="k1" x="1" y="0" operand="x"/>
    </rung>
    <rung id="2" width="2">
      <contact id="c1" x="0" y="0" operand="a" kind="nc"/>
      <coil id="k1" x="1" y="0" operand="x"/>
    </rung>
  </body>
</ladder>
"""
"""A program with one warning and no error."""

DANGLING = TWO_COILS.replace('<coil id="k1" x="1"', '<coil id="k1" x="5"').replace(
    'width="2"', 'width="6"')
"""A program that reads but does not compile: ends that meet nothing."""

BROKEN = SEAL_IN.replace('</body>', '')
"""No XML."""
