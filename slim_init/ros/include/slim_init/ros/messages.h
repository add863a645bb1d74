// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The generated message headers beside those of the library. ROS puts messages into the namespace
// of their package, where the library has an InitStatus and an InitResult of its own: include this
// file instead of <slim_init/InitResult.h> wherever both are needed, and write InitResultMessage.
// The types are the same; only the short names differ.
#pragma once

#define InitStatus InitStatusMessage
#define InitResult InitResultMessage
#include <slim_init/InitGate.h>
#include <slim_init/InitResult.h>
#include <slim_init/InitStage.h>
#include <slim_init/InitStatus.h>
#undef InitStatus
#undef InitResult
