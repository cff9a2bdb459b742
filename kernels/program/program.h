// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a program at one point, instruction by instruction: on graphics cards, for shadow rays and emitters on the CPU.
// The CPU's shading runs the same ops over batches of points (native/cpu_program.cpp).
#ifndef COTORRA_PROGRAM_H
#define COTORRA_PROGRAM_H

#include "context.h"
#include "ies.h"
#include "image_map.h"
#include "pure.h"
#include "table_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

struct ProgramRegisters {
  float v[PROGRAM_REGISTERS];
};

// The registers of a point. In GLSL they are the invocation's own memory: an argument would be copied at each call. In
// C++ whatever has numbers by place: a point's own, or its lane of a batch.
#ifdef __cplusplus
#define PROGRAM_MEMORY , auto &registers
#define PROGRAM_SAME_MEMORY , registers
#define PROGRAM_BEGIN_MEMORY ProgramRegisters registers
#else
ProgramRegisters registers;
#define PROGRAM_MEMORY
#define PROGRAM_SAME_MEMORY
#define PROGRAM_BEGIN_MEMORY
#endif

// Number `component` of what a reference names; `constants` is where the material's begin.
FN float program_number(IN(SceneData) scene, uint constants, uint reference, uint component PROGRAM_MEMORY) {
  const uint place = (reference & REFERENCE_MASK) + component;
  if ((reference & REFERENCE_CONSTANT) != 0u) return LOAD(scene.program_constants, constants + place);
  return registers.v[place];
}

FN vec3 program_vector(IN(SceneData) scene, uint constants, uint reference PROGRAM_MEMORY) {
  return vec3(program_number(scene, constants, reference, 0u PROGRAM_SAME_MEMORY),
              program_number(scene, constants, reference, 1u PROGRAM_SAME_MEMORY),
              program_number(scene, constants, reference, 2u PROGRAM_SAME_MEMORY));
}

FN vec3 program_table(IN(SceneData) scene, uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  if (op == OP_RAMP_V) return op_ramp_v(scene, mode, a.v[0], a.v[1], a.v[2]);
  if (op == OP_RAMP_ALPHA) return vec3(op_ramp_alpha(scene, mode, a.v[0], a.v[1], a.v[2]));
  if (op == OP_CURVE_F) return vec3(op_curve_f(scene, mode, a.v[0], a.v[1], a.v[2], a.v[3], a.v[4]));
  if (op == OP_IES_F) return vec3(op_ies_f(scene, p, a.v[3], a.v[4], a.v[5]));
  if (op == OP_RGB_CURVE_V) return op_rgb_curve_v(scene, mode, p, a.v[3], a.v[4], a.v[5], a.v[6]);
  return op_vector_curve_v(scene, mode, p, a.v[3], a.v[4], a.v[5], a.v[6]);
}

FN vec3 program_image(IN(SceneData) scene, uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  if (op == OP_IMAGE_V) return op_image_v(scene, mode, p, a.v[3], a.v[4], argument3(a, 5));
  if (op == OP_IMAGE_F) return vec3(op_image_f(scene, mode, p, a.v[3], a.v[4], argument3(a, 5)));
  return op_environment_v(scene, mode, p, a.v[3]);
}

FN vec3 program_op(IN(SceneData) scene, IN(ShaderPoint) at, uint op, uint mode, IN(ProgramArguments) a) {
  if (op < OP_SPLAT) return program_context(scene, at, op, mode, a);
  if (op < OP_RAMP_V) return program_pure(op, mode, a);
  if (PROGRAM_GROUP(GROUP_TABLE) && op < OP_IMAGE_V) return program_table(scene, op, mode, a);
  if (PROGRAM_GROUP(GROUP_IMAGE) && op >= OP_IMAGE_V) return program_image(scene, op, mode, a);
  return vec3(0.0f);
}

FN void program_run(IN(SceneData) scene, IN(ShaderPoint) at, IN(ProgramPart) part, uint constants PROGRAM_MEMORY) {
  uint word = part.first;
  while (word < part.end) {
    const uint head = LOAD(scene.program_code, word);
    const uint mode = LOAD(scene.program_code, word + 1u);
    const uint count = (head >> PROGRAM_COUNT_SHIFT) & PROGRAM_COUNT_MASK;
    word += 2u;
    // 1. The arguments, one after the other.
    ProgramArguments a;
    uint n = 0u;
    for (uint k = 0u; k < count; ++k) {
      const uint reference = LOAD(scene.program_code, word + k);
      const uint size = (reference & REFERENCE_VECTOR) != 0u ? 3u : 1u;
      for (uint c = 0u; c < size; ++c) {
        a.v[n] = program_number(scene, constants, reference, c PROGRAM_SAME_MEMORY);
        ++n;
      }
    }
    word += count;
    // 2. The op.
    const vec3 value = program_op(scene, at, head & PROGRAM_OP_MASK, mode, a);
    const uint place = head >> PROGRAM_RESULT_SHIFT;
    registers.v[place] = value.x;
    if ((head & PROGRAM_VECTOR) != 0u) {
      registers.v[place + 1u] = value.y;
      registers.v[place + 2u] = value.z;
    }
  }
}

// The three numbers that a part comes to.
FN vec3 program_value(IN(SceneData) scene, IN(ShaderPoint) at, IN(ProgramPart) part, uint constants) {
  PROGRAM_BEGIN_MEMORY;
  program_run(scene, at, part, constants PROGRAM_SAME_MEMORY);
  return program_vector(scene, constants, part.result PROGRAM_SAME_MEMORY);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
