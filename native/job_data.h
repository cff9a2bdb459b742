// SPDX-License-Identifier: GPL-3.0-or-later
// A session's job as the stages of every device read it. What the devices keep of it beside that is their own.
#pragma once

#include "../kernels/job.h"
#include "cpu_kernel.h"

namespace cotorra {

JobData job_data(const RenderJob &job);

}  // namespace cotorra
