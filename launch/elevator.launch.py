# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Start the 8-floor elevator, or the one of 3: plc_node and the plant with its passengers.

$ ros2 launch ladder_ros elevator.launch.py
$ ros2 run ladder_ros elevator_view            # in another terminal: the live picture
$ ros2 launch ladder_ros elevator.launch.py floors:=3
$ ros2 run ladder_ros elevator_view --floors 3
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start both nodes."""
    namespace, floors = LaunchConfiguration('namespace'), LaunchConfiguration('floors')
    return LaunchDescription([
        DeclareLaunchArgument('namespace', default_value='', description='Namespace of all nodes'),
        DeclareLaunchArgument(
            'floors', default_value='8', choices=['3', '8'], description='Which elevator it is'),
        DeclareLaunchArgument(
            'params_file',
            default_value=[PathJoinSubstitution(
                [FindPackageShare('ladder_ros'), 'config', 'elevator_']), floors, '_floor.yaml'],
            description='YAML file with the parameters of plc_node'),
        DeclareLaunchArgument('seed', default_value='15', description='Of the random passengers'),
        Node(
            package='ladder_ros', executable='plc_node', name='plc_node', namespace=namespace,
            output='screen', emulate_tty=True, sigterm_timeout='10',
            parameters=[LaunchConfiguration('params_file')]),
        Node(
            package='ladder_ros', executable='elevator_plant', name='elevator_plant',
            namespace=namespace, output='screen',
            arguments=['--seed', LaunchConfiguration('seed'), '--floors', floors]),
    ])
