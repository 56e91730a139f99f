# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The installed message types: their classes, and what fields they have."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
import os
from typing import Any

from ladder_ros.diagnostics import did_you_mean
from ladder_ros.ros.fields import FieldType, parse_type, UnknownMessage


@cache
def message_class(name: str) -> Any:
    """Return the class of a message type by its full name; raises UnknownMessage."""
    package, _, type_ = name.split('/')
    try:
        module = import_module(f'{package}.msg')
    except ImportError:
        system = f'ros-{os.environ.get("ROS_DISTRO", "jazzy")}-{package.replace("_", "-")}'
        raise UnknownMessage(
            f'the package {package} is not installed: install {system} (apt, or pip where ROS 2 '
            'comes from PyPI), or source the workspace that has it') from None
    found = getattr(module, type_, None)
    if not hasattr(found, 'get_fields_and_field_types'):
        known = [key for key, value in vars(module).items()
                 if hasattr(value, 'get_fields_and_field_types')]
        raise UnknownMessage(f'the package {package} has no message {type_}'
                             f'{did_you_mean(type_, known)}')
    return found


def new_message(name: str) -> Any:
    """Return an empty message of a type by its full name; raises UnknownMessage."""
    return message_class(name)()


@cache
def installed_fields(name: str) -> Mapping[str, FieldType]:
    """Return the fields of a message type: the :data:`Schema` of what is installed."""
    described: Mapping[str, str] = message_class(name).get_fields_and_field_types()
    return {field: parse_type(text) for field, text in described.items()}
