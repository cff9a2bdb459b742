// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the values that a part of a shader needs as instructions over registers.
// Which values there are is program_graph's business.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "program_compile.h"
#include "program_graph.h"

namespace cotorra {

class ProgramWriter {
 public:
  using Value = ProgramGraph::Value;
  struct Row {
    uint kind;
    uint mode;
    Value weight;
    std::vector<Value> arguments;
    std::optional<Value> own_normal = {};  // with CLOSURE_BENT_NORMAL
  };

  ProgramWriter(const ShaderInput &in, const ProgramGraph &graph, ProgramLibrary &library, CompiledShader &out)
      : in_(in), graph_(graph), library_(library), out_(out) {}

  // A program whose result is one value of three numbers.
  ProgramPart value(Value v);
  // A program whose result is a list of closures.
  ProgramPart closures(const std::vector<Row> &rows);
  // Of the program that was written last.
  const ProgramNeeds &needs() const { return needs_; }
  // The same, by instruction: the shader's op that it came from (ProgramGraph::Node::source).
  const std::vector<int> &sources() const { return sources_; }

 private:
  struct Place {
    uint reference = 0;
    bool written = false;
  };
  void begin(const std::vector<Value> &roots);
  void write(Value v);
  uint reference(Value v, bool vector);
  uint constant(vec3 value, bool vector);
  uint allocate(uint size);
  void release(Value v);
  ProgramPart finish(std::vector<uint> results, const std::vector<Row> &rows);

  const ShaderInput &in_;
  const ProgramGraph &graph_;
  ProgramLibrary &library_;
  CompiledShader &out_;
  std::vector<uint> code_;
  std::vector<int> sources_;
  ProgramNeeds needs_;
  std::vector<uint> uses_;
  std::vector<Place> places_;
  std::vector<char> taken_;  // registers
};

}  // namespace cotorra
