# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# slim_init and VINS-Mono, patched and built in one catkin workspace on Ubuntu 20.04 with ROS Noetic.
# From the root of this repository:
#   docker build -f launch/docker/ubuntu2004_noetic.Dockerfile -t slim_init:noetic .
#   docker run --rm -it -v "$PWD/data:/data" slim_init:noetic
# NOT BUILT: neither this image nor the workspace in it has been built by the authors, who had
# Debian 12 only. Versions are as published for Ubuntu 20.04: g++ 9.3, CMake 3.16, Eigen 3.3.7,
# OpenCV 4.2, Ceres 1.14. A report of what it needs is welcome.
FROM ros:noetic-ros-base-focal

ENV DEBIAN_FRONTEND=noninteractive
SHELL ["/bin/bash", "-c"]

# What VINS-Mono needs. rviz is left out: the launch files do without.
RUN apt-get update && apt-get install -y --no-install-recommends \
      git ros-noetic-cv-bridge ros-noetic-image-transport ros-noetic-message-filters \
      ros-noetic-tf libopencv-dev libceres-dev \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /catkin_ws/src
COPY . slim_init
RUN apt-get update \
    && bash -c '. slim_init/launch/setup.sh; slim_init_install_packages' \
    && rm -rf /var/lib/apt/lists/*

# The commit that the insertions were checked at. OpenCV 4.2; with Ceres 1.14 it stays C++11.
RUN git clone https://github.com/HKUST-Aerial-Robotics/VINS-Mono.git \
    && git -C VINS-Mono checkout -q 90dabb5 \
    && slim_init/vins_estimator_patch/for_opencv4.sh VINS-Mono \
    && python3 slim_init/vins_estimator_patch/apply.py VINS-Mono

WORKDIR /catkin_ws
# A C++ file takes up to 1 GB of memory: two at a time, and none more while the load is above 2.
RUN . /opt/ros/noetic/setup.bash && catkin_make -j2 -l2 -DCMAKE_BUILD_TYPE=Release
# Whatever is run, is run in the workspace.
ENTRYPOINT ["/bin/bash", "-c", ". /catkin_ws/devel/setup.bash && exec \"$@\"", "--"]
CMD ["bash"]
