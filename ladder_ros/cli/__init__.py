# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The command ``ladder``: one file a verb, each a thin door to a facade.

A verb takes its arguments and returns an :class:`~ladder_ros.cli.verb.Answer`; ``main`` alone
prints, catches errors and chooses the exit status.
"""
