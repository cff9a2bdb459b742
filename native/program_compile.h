// SPDX-License-Identifier: GPL-3.0-or-later
// Shader trees to programs: folds what is constant, shares equal parts, leaves out what is not used, gives out
// registers, and finds equal programs. Trees are read in Python (addon/shader/), programs run in kernels/program/.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "../kernels/closure/kinds.h"
#include "../kernels/program/types.h"

namespace cotorra {

// One op as kernels/program/ops.inc lists it.
struct OpInfo {
  const char *name;
  uint number;
  bool pure;              // depends on its arguments (and tables) alone
  bool table;             // reads tables or images
  char result;            // f or v
  std::string arguments;  // f and v
};
std::span<const OpInfo> program_ops();
const OpInfo *find_op(uint number);  // nullptr: none has this number

struct ClosureInfo {
  const char *name;
  uint kind;
  const char *arguments;
};
std::span<const ClosureInfo> program_closures();

// Views of a Shader of addon/export/buffers.py, which tells what each is.
struct ShaderInput {
  std::string name;
  std::span<const uint> ops;
  std::span<const uint> modes;
  std::span<const int> args;
  std::span<const vec3> constants;
  struct Closure {
    uint kind;
    uint mode;
    int weight;
    uint first_argument;
  };
  std::span<const Closure> closures;
  std::span<const int> closure_args;
  std::span<const float> tables;
};

// The constants of a surface that is one Principled closure with nothing but constants.
struct PlainSurface {
  bool plain = false;
  vec3 base_color{0.8f, 0.8f, 0.8f};
  float metallic = 0.0f;
  float roughness = 0.5f;
  float ior = 1.5f;
  float specular_level = 0.5f;
  vec3 specular_tint{1.0f, 1.0f, 1.0f};
  bool multi_ggx = true;
  float transmission = 0.0f;  // share of clear glass where that is a constant, plain or not
};

// What of the ops a program needs: GROUP_* and PROGRAM_VARIANT bits of kernels/program/ops.h.
struct ProgramNeeds {
  uint groups = 0;
  uint variants = 0;
  bool footprint = false;  // how wide the ray is
  bool point = false;      // more of the point than its place on its mesh
  void add(const ProgramNeeds &other) {
    groups |= other.groups;
    variants |= other.variants;
    footprint |= other.footprint;
    point |= other.point;
  }
};

// What programs need that may hold any of these ops; of noise, every variant. Throws std::invalid_argument for a name
// that no op has.
ProgramNeeds needs_of_ops(std::span<const std::string> names);

// What became of a shader's ops and closures beside its programs, for people (program_listing.h).
struct CompileNotes {
  struct Folded {
    uint op;  // of the shader's
    vec3 value;
  };
  struct Dropped {
    uint closure;  // of the shader's
    uint why;      // 0: its weight is 0, 1: its alpha, 2: its colour
  };
  std::vector<Folded> folded;
  std::vector<Dropped> dropped;
  // Of each instruction of a part the op that it came from, and of each closure the shader's; -1 where compiling made
  // it.
  std::vector<int> surface_sources, emission_sources, transparency_sources, closure_sources;
};

// What one shader became; before that, the default grey.
struct CompiledShader {
  MaterialProgram program{{NO_PROGRAM, 0, 0, 0}, {NO_PROGRAM, 0, 0, 0}, {NO_PROGRAM, 0, 0, 0}, 0, 0};
  PlainSurface surface;        // where program.surface is NO_PROGRAM
  vec3 emission{0.0f};         // where program.emission is NO_PROGRAM
  vec3 transparency{0.0f};     // where program.transparency is NO_PROGRAM
  // Of an emission that varies: the sides (MATERIAL_*_DARK) to which it is 0 wherever it is asked for, and what it is
  // to the other where that is the same everywhere.
  uint dark = 0;
  bool lit_evenly = false;
  vec3 lit{0.0f};
  bool grey = true;  // what is let through has no colour
  bool sharp = false;  // a lobe may be narrow
  bool asks_lobes = false;  // a closure is more than bsdf.h knows
  bool transmits = false;  // a closure sends light through the surface
  ProgramNeeds surface_needs, emission_needs, transparency_needs;
  uint lobes = 0;  // bit a CLOSURE_* kind of the surface
  std::uint64_t ops_used[8]{};  // by number of the op
  CompileNotes notes;

  bool varies() const {
    return program.surface.first != NO_PROGRAM || program.emission.first != NO_PROGRAM ||
           program.transparency.first != NO_PROGRAM;
  }
};

// The programs of a scene: code and constants of all its shaders.
class ProgramLibrary {
 public:
  // Throws std::invalid_argument that names the shader where its arrays do not make sense, or where it needs more
  // registers than there are.
  CompiledShader add(const ShaderInput &shader);

  // The scene's images, to be told before: 1 where alpha is 1 everywhere, so that it is a constant.
  std::vector<char> opaque_images;

  std::vector<uint> code;
  std::vector<ClosureRow> closures;
  std::vector<float> constants;
  std::vector<float> tables;
  uint registers = 0;  // that the largest program needs

 private:
  friend class ProgramWriter;
  std::map<std::vector<uint>, ProgramPart> shapes_;  // by all that was written
};

}  // namespace cotorra
