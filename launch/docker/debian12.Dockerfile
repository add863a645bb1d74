# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# slim_init and VINS-Mono, patched and built in one catkin workspace on Debian 12 with its own
# packages of ROS 1. From the root of this repository:
#   docker build -f launch/docker/debian12.Dockerfile -t slim_init:debian12 .
#   docker run --rm -it -v "$PWD/data:/data" slim_init:debian12
# The image was not built where this was written, for want of docker; the packages, the changes to
# VINS-Mono and the patch are those of docs/vins_mono.md.
FROM debian:12

ENV DEBIAN_FRONTEND=noninteractive
SHELL ["/bin/bash", "-c"]

# ROS and what VINS-Mono needs. rviz is left out: the launch files do without.
RUN apt-get update && apt-get install -y --no-install-recommends \
      ca-certificates git g++ make cmake catkin rosbash python3-roslaunch python3-rosbag \
      python3-rostopic libroscpp-dev libtf-dev libcv-bridge-dev libimage-transport-dev \
      libmessage-filters-dev libroslib-dev ros-message-generation ros-std-msgs ros-geometry-msgs \
      ros-sensor-msgs ros-nav-msgs libopencv-dev libceres-dev \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /catkin_ws/src
COPY . slim_init
RUN apt-get update \
    && bash -c '. slim_init/launch/setup.sh; slim_init_install_packages' \
    && rm -rf /var/lib/apt/lists/*

# The commit that the insertions were checked at. OpenCV 4.6 and Ceres 2.1: docs/hosts.md.
RUN git clone https://github.com/HKUST-Aerial-Robotics/VINS-Mono.git \
    && git -C VINS-Mono checkout -q 90dabb5 \
    && slim_init/vins_estimator_patch/for_opencv4.sh VINS-Mono --cxx17 \
    && python3 slim_init/vins_estimator_patch/apply.py VINS-Mono

WORKDIR /catkin_ws
# A C++ file takes up to 1 GB of memory: two at a time, and none more while the load is above 2.
RUN catkin_make -j2 -l2 -DPYTHON_EXECUTABLE=/usr/bin/python3 -DCMAKE_BUILD_TYPE=Release
# Whatever is run, is run in the workspace.
ENTRYPOINT ["/bin/bash", "-c", ". /catkin_ws/devel/setup.bash && exec \"$@\"", "--"]
CMD ["bash"]
