// SPDX-License-Identifier: GPL-3.0-or-later
// Ops as loops over columns of arguments that the compiler vectorises, from the kernels' own functions.
// Included by cpu_program.cpp alone; an op without a loop here is called point by point.
#pragma once

#include "../kernels/program/program.h"

namespace cotorra {
namespace {

// Runs the op for n points and returns true where it has a loop.
bool run_loop(uint op, uint mode, const float *const *a, int n, float *const *out) {
  (void)op, (void)mode, (void)a, (void)n, (void)out;
  return false;
}

}  // namespace
}  // namespace cotorra
