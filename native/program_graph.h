// SPDX-License-Identifier: GPL-3.0-or-later
// The values of one shader as a graph: constants and ops on earlier values, each value once.
// Constants are folded when a value is made; what nobody asks for is never written into a program (program_writer).
#pragma once

#include <functional>
#include <map>
#include <span>
#include <vector>

#include "program_compile.h"

namespace cotorra {

// Runs one op that depends on its arguments alone. Its tables are the shader's own.
vec3 program_fold(uint op, uint mode, std::span<const float> arguments, std::span<const float> tables);

// Operations that Math and Vector Math number alike, as Blender does.
constexpr uint MATH_ADD = 0, MATH_SUBTRACT = 1, MATH_MULTIPLY = 2, MATH_DIVIDE = 3;

class ProgramGraph {
 public:
  using Value = int;
  struct Node {
    const OpInfo *op = nullptr;  // nullptr: a constant
    uint mode = 0;
    std::vector<Value> arguments;
    vec3 constant{0.0f};
    int source = -1;  // of the shader's ops, the first that came to this; -1: compiling made it
  };

  explicit ProgramGraph(std::span<const float> tables) : tables_(tables) {}

  Value constant(vec3 value);
  Value constant(float value) { return constant(vec3(value)); }
  // The op's value: an earlier one where it is the same, a constant where it can only be that.
  Value op(uint number, uint mode, std::vector<Value> arguments);

  void set_source(Value v, std::size_t op) {
    int &own = nodes_[static_cast<std::size_t>(v)].source;
    if (own < 0) own = static_cast<int>(op);
  }
  const Node &operator[](Value v) const { return nodes_[static_cast<std::size_t>(v)]; }
  std::size_t size() const { return nodes_.size(); }
  bool is_constant(Value v) const { return (*this)[v].op == nullptr; }
  bool is_constant(Value v, float x) const;  // in all components
  bool is_vector(Value v) const { return !is_constant(v) && (*this)[v].op->result == 'v'; }
  // Certainly the same in all components.
  bool is_grey(Value v) const;

  // `v` where every op of this number has a constant value instead.
  Value with(Value v, uint number, vec3 value);

  // ---- Arithmetic that compiling needs, on three numbers each.
  Value add(Value a, Value b);
  Value subtract(Value a, Value b);
  Value multiply(Value a, Value b);
  Value divide(Value a, Value b);  // 0 where b is 0
  Value splat(Value number);
  Value saturate(Value number);    // of one number

 private:
  Value simplified(uint number, uint mode, const std::vector<Value> &arguments);
  Value vector_math(uint operation, Value a, Value b);
  Value affine(uint mode, const std::vector<Value> &arguments);

  std::span<const float> tables_;
  std::vector<Node> nodes_;
  std::map<std::vector<uint>, Value> known_;
  std::map<std::vector<uint>, Value> known_constants_;
  std::vector<char> grey_;
};

}  // namespace cotorra
