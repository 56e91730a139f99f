# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The node's services: ``~/reload``, ``~/start``, ``~/stop``, ``~/reset`` (std_srvs/Trigger).

The reply's ``message`` is one JSON document, whether it went well or not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
import json
from typing import Any

from std_srvs.srv import Trigger

from ladder_ros.diagnostics import LadderError

Report = Mapping[str, object]

SHOWN_DIAGNOSTICS = 50


def failure(error: Exception) -> dict[str, object]:
    """Return an error as plain JSON data."""
    if isinstance(error, LadderError):
        shown = [item.to_json() for item in error.diagnostics[:SHOWN_DIAGNOSTICS]]
        return {'success': False, 'error': str(error.diagnostics[0]), 'diagnostics': shown}
    return {'success': False, 'error': f'{type(error).__name__}: {error}', 'diagnostics': []}


def serve(
    node: Any, actions: Mapping[str, Callable[[], Report]], on_error: Callable[[Exception], None],
) -> None:
    """Offer each action as the service ``~/<name>``.

    An action returns what it did, or raises; ``on_error`` is told what it raised.
    """
    def offer(name: str, action: Callable[[], Report]) -> None:
        def respond(_request: Any, response: Any) -> Any:
            try:
                report = {'success': True, **action()}
            except Exception as error:  # a service must answer
                on_error(error)
                report = failure(error)
            response.success = bool(report['success'])
            response.message = json.dumps(report)
            return response

        node.create_service(Trigger, f'~/{name}', respond)

    for name, action in actions.items():
        offer(name, action)
