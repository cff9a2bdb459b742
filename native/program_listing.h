// SPDX-License-Identifier: GPL-3.0-or-later
// Programs as people read them: instructions whose arguments are earlier instructions or constants, and what one run
// costs. Words for all this are addon/shader/'s; programs are made in program_compile.cpp.
#pragma once

#include <vector>

#include "program_compile.h"

namespace cotorra {

class Scene;

struct ListedValue {
  int instruction = -1;  // of the same part; -1: a constant
  bool vector = false;
  vec3 constant{0.0f};
};

struct ListedInstruction {
  const OpInfo *op;
  uint mode;
  std::vector<ListedValue> arguments;
  int source;  // as in CompileNotes
};

struct ListedClosure {
  const ClosureInfo *kind;
  uint mode;
  ListedValue weight;
  std::vector<ListedValue> arguments;
};

struct ProgramListing {
  std::vector<ListedInstruction> instructions;
  uint registers = 0;
  std::vector<ListedClosure> closures;  // of a surface
  ListedValue result;                   // of the other parts
};

// A part that is a program. sources: as in CompileNotes.
ProgramListing list_program(const ProgramLibrary &library, const MaterialProgram &program, const ProgramPart &part,
                            const std::vector<int> &sources);

// Nanoseconds that the instructions of a part take for one point on one thread of the CPU, in batches as renders run
// them; closures are not evaluated. Points lie on the scene's first instance, or are directions where there is none.
double program_cost(const Scene &scene, const MaterialProgram &program, const ProgramPart &part);

}  // namespace cotorra
