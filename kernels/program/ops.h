// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of the ops of shading programs, OP_MATH and the like, made from the list in ops.inc.
// What they compute stands in the files beside this one.
#ifndef COTORRA_PROGRAM_OPS_H
#define COTORRA_PROGRAM_OPS_H

#include "../language.h"

#ifdef __cplusplus
namespace cotorra {
#endif

#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) const uint CONSTANT = NUMBER;
#include "ops.inc"
#undef PROGRAM_OP

const uint OP_NUMBERS = 160u;  // all are below

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
