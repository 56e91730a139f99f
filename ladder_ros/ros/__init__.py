# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 node: a ladder program's inputs and outputs on topics.

``node`` starts and stops the process, ``plc`` joins the session with the ROS side, ``parameters``
reads what the user set, ``io_map`` decides which variable lies on which topic, ``bindings`` holds
the publishers and subscriptions, ``conversions`` brings values into messages and back.
"""
