// SPDX-License-Identifier: GPL-3.0-or-later
// Programs in memory: what shader trees became, as every device reads it. How they run is in program.h; how they are
// made is native/program_compile.cpp's.
#ifndef COTORRA_PROGRAM_TYPES_H
#define COTORRA_PROGRAM_TYPES_H

#include "../language.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The code of a program is a stream of words. An instruction is
//   word 0: op | PROGRAM_VECTOR where the result has three numbers | arguments << PROGRAM_COUNT_SHIFT
//           | first register of the result << PROGRAM_RESULT_SHIFT
//   word 1: the op's mode
//   then one reference for each argument.
// A reference names a register, or with REFERENCE_CONSTANT a number among the material's constants; with
// REFERENCE_VECTOR it and the two that follow it.
const uint PROGRAM_OP_MASK = 511u;
const uint PROGRAM_VECTOR = 512u;
const uint PROGRAM_COUNT_SHIFT = 10u;
const uint PROGRAM_COUNT_MASK = 63u;
const uint PROGRAM_RESULT_SHIFT = 16u;
const uint REFERENCE_CONSTANT = 0x80000000u;
const uint REFERENCE_VECTOR = 0x40000000u;
const uint REFERENCE_MASK = 0x3fffffffu;
const uint PROGRAM_REGISTERS = 160u;  // a program has at most; a number each
const uint PROGRAM_ARGUMENTS = 32u;   // numbers that one op takes at most

const uint NO_PROGRAM = 0xffffffffu;

// A part of a material that varies: its code, and what is read when it has run.
struct ProgramPart {
  uint first;      // word of the code; NO_PROGRAM: this part is constant, and stands in Material
  uint end;        // word behind the last instruction
  uint result;     // emission, transparency: a reference to the three numbers; surface: its first ClosureRow
  uint closures;   // surface: how many
};

// Bits of MaterialProgram.flags: what need not be done.
const uint PROGRAM_PLAIN = 1u;      // the surface is one closure, a Principled one that bsdf.h knows whole
const uint PROGRAM_FOOTPRINT = 2u;  // the surface asks how wide the ray is, or traces rays of its own
const uint PROGRAM_PLACE = 4u;      // of a point, the transparency asks no more than its place on its mesh

// What the shader of a material became. The three parts are programs of their own, so that a shadow ray runs nothing
// but what tells the transparency.
struct MaterialProgram {
  ProgramPart surface;
  ProgramPart emission;
  ProgramPart transparency;
  uint constants;  // first of the material's numbers
  uint flags;
};

// One closure of a surface; its weight and arguments are references, the latter from word `arguments` of the code on.
struct ClosureRow {
  uint kind;  // CLOSURE_*
  uint mode;
  uint weight;
  uint arguments;
};

BUFFER_REF(MaterialProgram, MaterialProgramBuffer)
BUFFER_REF(ClosureRow, ClosureRowBuffer)

#ifdef __cplusplus
static_assert(sizeof(ProgramPart) == 16 && sizeof(MaterialProgram) == 56 && sizeof(ClosureRow) == 16);
}  // namespace cotorra
#endif

#endif
