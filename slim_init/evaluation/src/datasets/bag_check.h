// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Whether the index of a bag is one that the rosbag library can follow. That library takes the
// offsets in it as they are; a damaged one makes it read outside its memory.
#pragma once

#include <string>

namespace slim_init::evaluation {

/// Follows every record of a bag (format 2.0, http://wiki.ros.org/Bags/Format/2.0) and every entry
/// of its index to the message it points at. Returns an empty string, or a phrase saying at which
/// byte what is wrong with which bound. Compressed chunks are unpacked for this, of others only the
/// beginnings of the messages are read. May throw what reading and unpacking throw.
std::string bagDamage(const std::string& path);

}  // namespace slim_init::evaluation
