# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Proofs about programs: that two behave alike, that one never comes to what must not be.

A scan is made a function of terms (`machine`, by `functions` and `block_paths`); what holds after
every scan is found by induction (`induction`, `invariants`), what differs by unrolling scans
(`unroll`); `decide` and `properties` put that in order.  `to_z3` alone knows the solver.
"""
