# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of rungs, drawn from the model alone, right or wrong as the drawing may be.

``shapes`` says what a component looks like, ``joints`` where lines meet, ``layout`` how much room
each column and row needs, ``canvas`` holds characters; ``rung_text`` puts them together.
"""
