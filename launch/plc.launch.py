# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Start plc_node with a program, a parameter file, or both.

$ ros2 launch ladder_ros plc.launch.py program:=/opt/cell/press.xml
$ ros2 launch ladder_ros plc.launch.py params_file:=/opt/cell/cell.yaml namespace:=cell_1
"""

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity


def _value(context: LaunchContext, name: str) -> str:
    return LaunchConfiguration(name).perform(context)


def _plc_node(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the node; an argument that is left empty leaves the parameter file its say."""
    settings = {'use_sim_time': _value(context, 'use_sim_time').lower() in ('true', '1')}
    if _value(context, 'autostart'):
        settings['autostart'] = _value(context, 'autostart').lower() in ('true', '1')
    if _value(context, 'program'):
        settings['program'] = _value(context, 'program')
    params_file = _value(context, 'params_file')
    return [Node(
        package='ladder_ros', executable='plc_node', name=_value(context, 'name'),
        namespace=_value(context, 'namespace'), output='screen', emulate_tty=True,
        parameters=[*([params_file] if params_file else []), settings],
        # Longer than launch waits by default, for the safe values of the outputs to get through.
        sigterm_timeout='10',
    )]


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the node."""
    return LaunchDescription([
        DeclareLaunchArgument(
            'program', default_value='',
            description='Ladder program: a path, file://... or package://<package>/<path>'),
        DeclareLaunchArgument(
            'params_file', default_value='',
            description='YAML file with the parameters of plc_node, the I/O map among them'),
        DeclareLaunchArgument('name', default_value='plc_node', description='Name of the node'),
        DeclareLaunchArgument('namespace', default_value='', description='Namespace of the node'),
        DeclareLaunchArgument(
            'use_sim_time', default_value='false', choices=['true', 'false'],
            description='Whether scans step with /clock'),
        DeclareLaunchArgument(
            'autostart', default_value='', choices=['', 'true', 'false'],
            description='false: a lifecycle manager configures and activates the node'),
        OpaqueFunction(function=_plc_node),
    ])
