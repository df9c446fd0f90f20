// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/ceiling_noise.h"

namespace nightmap {}  // namespace nightmap
