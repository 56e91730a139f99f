# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The node's services, all of them std_srvs/Trigger.

The reply's ``message`` is one JSON document, whether it went well or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
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
    after: Callable[[Report], Report], in_turns: Callable[[Iterator[str]], Iterator[str]],
) -> dict[str, Any]:
    """Offer each action as the service ``~/<name>``.

    An action returns what it did (with a false ``success`` if that was a refusal), or raises;
    ``on_error`` is told what it raised.  ``after`` gets the report and adds to it.
    ``in_turns`` is how a long text is made while scans go on.  Returns the services by name.
    """
    def respond(action: Callable[[], Report], response: Any) -> Any:
        report: dict[str, object]
        try:
            report = {'success': True, **action()}
        except Exception as error:  # a service must answer
            on_error(error)
            report = failure(error)
        report.update(after(report))
        response.success = bool(report['success'])
        # Not by json.dumps, which lets no scan begin before it is done.
        response.message = ''.join(in_turns(json.JSONEncoder().iterencode(report)))
        return response

    return {
        name: node.create_service(
            Trigger, f'~/{name}',
            lambda _request, response, action=action: respond(action, response))
        for name, action in actions.items()}


def answer(service: Any) -> bool:
    """Answer a request if one waits, for while the callback thread is busy with something long.

    Returns whether one did.
    """
    with service.handle:
        request, header = service.handle.service_take_request(service.srv_type.Request)
    if header is None:
        return False
    service.send_response(service.callback(request, service.srv_type.Response()), header)
    return True
