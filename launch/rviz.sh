#!/bin/sh
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#
# rviz where it is installed, and one sentence where it is not: the launch files start it through
# this, so that its absence is no error.
if program="$(command -v rviz)"; then
  exec "${program}" "$@"
fi
echo "slim_init: rviz is not installed, so nothing is drawn; the nodes run as they do with it" \
  "(rviz:=false leaves it out)"
