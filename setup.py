# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Install ladder_ros with pip or with colcon (ament_python)."""

from __future__ import annotations

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'ladder_ros'
SHARE = f'share/{PACKAGE}'

# What users look for in the share folder, copied whole: (folder, what belongs there).
SHARED_FOLDERS = (
    ('programs', ('*.xml', '*.csv', '*.md')),
    ('config', ('*.yaml', '*.xml', '*.rviz', '*.md')),
    ('launch', ('*.py', '*.xml', '*.yaml')),
)

# The real ROS 2 client library as wheels, for machines without ROS 2. They exist for this kind of
# machine only; elsewhere the extra installs nothing and rclpy comes from a ROS 2 installation.
ROS_WHEELS_EXIST = (
    'sys_platform == "linux" and platform_machine == "x86_64" '
    'and python_version >= "3.10" and python_version < "3.14"'
)
ROS_WHEELS = (
    'ros-jazzy-rclpy[fastrtps] >= 7.1.6, < 8',
    'ros-jazzy-ament-index-python >= 1.8.1, < 2',
    'ros-jazzy-diagnostic-msgs >= 5.3.6, < 6',
    'ros-jazzy-lifecycle-msgs >= 2.0.3, < 3',
    'ros-jazzy-rcl-interfaces >= 2.0.3, < 3',
    'ros-jazzy-rosgraph-msgs >= 2.0.3, < 3',
    'ros-jazzy-std-msgs >= 5.3.6, < 6',
    'ros-jazzy-std-srvs >= 5.3.6, < 6',
)

# Message types that the tests map fields of; nothing in the package needs them.
TEST_WHEELS = (
    'ros-jazzy-geometry-msgs >= 5.3.6, < 6',
    'ros-jazzy-sensor-msgs >= 5.3.6, < 6',
)


def shared_files() -> list[tuple[str, list[str]]]:
    """List the files of the share folder as ``data_files``: (folder there, files here)."""
    found: dict[str, list[str]] = {}
    for folder, patterns in SHARED_FOLDERS:
        for pattern in patterns:
            for path in sorted(Path(folder).rglob(pattern)):
                found.setdefault(f'{SHARE}/{path.parent.as_posix()}', []).append(path.as_posix())
    return list(found.items())


setup(
    name=PACKAGE,
    version='0.1.0',
    description='Ladder diagrams with composite components as a native ROS 2 node',
    long_description=(
        'Reads ladder programs made of composite components (own XML or PLCopen TC6 XML), '
        'compiles them and runs them in scan cycles as a ROS 2 node on ordinary topics.'
    ),
    author='ladder_ros developers',
    maintainer='ladder_ros developers',
    maintainer_email='ladder_ros@example.org',
    license='Apache-2.0',
    keywords=['ROS', 'PLC', 'ladder diagram', 'IEC 61131-3', 'PLCopen'],
    classifiers=[
        'Intended Audience :: Manufacturing',
        'Operating System :: POSIX :: Linux',
        'Programming Language :: Python :: 3 :: Only',
        'Programming Language :: Python :: 3.10',
        'Programming Language :: Python :: 3.11',
        'Programming Language :: Python :: 3.12',
        'Programming Language :: Python :: 3.13',
        'Typing :: Typed',
    ],
    python_requires='>= 3.10',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={PACKAGE: ['py.typed', 'source/*.lark', 'source/schema/*.xsd']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (SHARE, ['package.xml']),
        *shared_files(),
    ],
    zip_safe=False,
    install_requires=[
        'lark >= 1.1',
        'PyYAML >= 5.4.1',
        'typing_extensions >= 4.1',
    ],
    extras_require={
        'ros': [f'{wheel} ; {ROS_WHEELS_EXIST}' for wheel in ROS_WHEELS],
        'native': ['llvmlite >= 0.45, < 1'],
        'prove': ['z3-solver >= 4.8.12'],
        'bag': ['rosbags >= 0.10.6, < 1'],
        'test': [
            'hypothesis >= 6.80',
            'llvmlite >= 0.45, < 1',
            'lxml >= 4.8',
            'mypy >= 1.11',
            'pyelftools >= 0.29',
            'pytest >= 7.4',
            'pytest-timeout >= 2.2',
            'pytest-xdist >= 3.3',
            'rosbags >= 0.10.6, < 1',
            'ruff >= 0.6',
            'setuptools >= 70.1',
            'types-PyYAML >= 6.0',
            'unicorn >= 2.1',
            *(f'{wheel} ; {ROS_WHEELS_EXIST}' for wheel in TEST_WHEELS),
            'z3-solver >= 4.8.12',
        ],
    },
    entry_points={
        'console_scripts': [
            'ladder = ladder_ros.cli.main:main',
            'plc_node = ladder_ros.ros.node:main',
            'elevator_plant = ladder_ros.demo.elevator_plant:main',
            'elevator_view = ladder_ros.demo.elevator_view:main',
            'elevator_demo = ladder_ros.demo.elevator_demo:main',
        ],
    },
)
