# soft_sim_ros in a ROS 2 Jazzy of its own, for users:
#
#     docker build -t soft_sim_ros .
#     docker run --rm -it --net=host -v "$PWD/runs:/runs" soft_sim_ros \
#         simulate --ros-args -p scene:=soft_arm -p record:=/runs/first
#
# Any verb of `ros2 run soft_sim_ros` can follow the name of the image; `bash` opens a shell.
FROM ros:jazzy

ENV PIP_BREAK_SYSTEM_PACKAGES=1
SHELL ["/bin/bash", "-c"]
WORKDIR /ws
COPY . src/soft_sim_ros

RUN apt-get update \
    && apt-get install -y --no-install-recommends python3-pip \
    && rosdep update --rosdistro jazzy \
    && rosdep install --from-paths src --ignore-src -y --dependency-types=exec \
    && source /opt/ros/jazzy/setup.bash \
    && colcon build --packages-select soft_sim_ros \
    && rm -rf /var/lib/apt/lists/* log

# kernels compiled once, here, and not at the first start of every container
ENV XDG_CACHE_HOME=/ws/cache
RUN source install/setup.bash \
    && python3 src/soft_sim_ros/tools/warm_up.py soft_arm

COPY docker/entrypoint.sh /entrypoint.sh
ENTRYPOINT ["/entrypoint.sh"]
CMD ["simulate"]
