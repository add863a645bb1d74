// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/imu_limits.h"

#include "data/range_check.h"
#include "slim_init/option_table.h"
#include "slim_init/text.h"

namespace slim_init {

bool ImuLimits::exceededBy(const ImuSample& sample) const {
  return sample.accel.allFinite() && sample.gyro.allFinite() &&
         (sample.accel.cwiseAbs().maxCoeff() > max_accel ||
          sample.gyro.cwiseAbs().maxCoeff() > max_gyro);
}

std::string ImuLimits::describe(const ImuSample& sample) const {
  return roundedText(3, sample.accel.cwiseAbs().maxCoeff(), " m/s^2 and ",
                     sample.gyro.cwiseAbs().maxCoeff(), " rad/s on an axis (limits ", max_accel,
                     " m/s^2, ", max_gyro, " rad/s)");
}

std::string ImuLimits::validate() const {
  ImuLimits copy = *this;
  return RangeCheck().within(optionTable(&copy)).message();
}

}  // namespace slim_init
