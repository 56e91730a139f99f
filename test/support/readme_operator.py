# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the README does with ``ros2``: look at the motor, change the program, look at the fan.

A process of its own, as the operator's terminal is: waits for the motor, sets the parameter
``program`` to ``with_fan.xml``, and prints what it saw.
"""

from __future__ import annotations

import time
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool

SECONDS = 20.0


def main() -> None:
    """Run the steps in order; raises TimeoutError if one takes too long."""
    rclpy.init()
    node = rclpy.create_node('operator')
    seen: dict[str, bool] = {}
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

    def watch(name: str, topic: str) -> None:
        node.create_subscription(
            Bool, topic, lambda message: seen.__setitem__(name, message.data), latched)

    def until(condition: Any) -> None:
        deadline = time.monotonic() + SECONDS
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f'only seen: {seen}')
            rclpy.spin_once(node, timeout_sec=0.1)

    watch('motor', '/cell/motor')
    watch('fan', '/plc_node/fan')
    until(lambda: seen.get('motor'))
    print(f'motor={seen["motor"]}')
    client = node.create_client(SetParameters, '/plc_node/set_parameters')
    if not client.wait_for_service(SECONDS):
        raise TimeoutError('no /plc_node/set_parameters')
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='with_fan.xml')
    request = SetParameters.Request(parameters=[Parameter(name='program', value=value)])
    future = client.call_async(request)
    until(future.done)
    result = future.result().results[0]
    print(f'changed={result.successful}{result.reason}')
    until(lambda: seen.get('fan'))
    print(f'fan={seen["fan"]}')
    print(f'motor={seen["motor"]}')


if __name__ == '__main__':
    main()
