#!/bin/bash
# A verb of soft_sim_ros, or any other command, in the workspace of the image.
set -e
source /ws/install/setup.bash
if [ -x "/ws/install/soft_sim_ros/lib/soft_sim_ros/$1" ]; then
    exec ros2 run soft_sim_ros "$@"
fi
exec "$@"
