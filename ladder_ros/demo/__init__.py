# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The 3-floor elevator as a live demonstration: plant, view and runner, over real topics.

``elevator_model`` is the physics and the passengers, ``elevator_plant`` puts them on topics,
``elevator_view`` draws what the topics say, ``elevator_demo`` runs everything.
"""
