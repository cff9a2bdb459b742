// SPDX-License-Identifier: GPL-3.0-or-later
// Gives out registers and writes instructions. How people read them is program_listing.cpp's.
#include "program_writer.h"

#include <algorithm>
#include <stdexcept>

#include "../kernels/program/ops.h"
#include "../kernels/program/point.h"

namespace cotorra {

// Counts who asks for what, from the last value to the first.
void ProgramWriter::begin(const std::vector<Value> &roots) {
  code_.clear();
  sources_.clear();
  needs_ = {GROUP_PROGRAM, 0};
  uses_.assign(graph_.size(), 0);
  places_.assign(graph_.size(), {});
  taken_.assign(PROGRAM_REGISTERS, 0);
  for (const Value v : roots) ++uses_[static_cast<std::size_t>(v)];
  for (std::size_t k = graph_.size(); k-- > 0;) {
    if (uses_[k] == 0) continue;
    for (const Value a : graph_[static_cast<Value>(k)].arguments) ++uses_[static_cast<std::size_t>(a)];
  }
  for (std::size_t k = 0; k < graph_.size(); ++k) {
    if (uses_[k] > 0 && !graph_.is_constant(static_cast<Value>(k))) write(static_cast<Value>(k));
  }
}

// What the instruction of a node needs.
static ProgramNeeds needs_of(const ProgramGraph::Node &node) {
  const uint op = node.op->number;
  const uint group = program_group(op);
  const bool moved = group == GROUP_COORDINATES && node.mode >> 30 != SHIFT_NONE;
  const bool of_mesh = op == OP_PARAMETRIC || op == OP_GENERATED || (op >= OP_ATTRIBUTE && op <= OP_ATTRIBUTE_FAC);
  return {group, program_variants(op, node.mode), moved || op == OP_BUMP || op == OP_WIREFRAME,
          op < OP_SPLAT && (moved || !of_mesh)};
}

void ProgramWriter::write(Value v) {
  const ProgramGraph::Node &node = graph_[v];
  const bool vector = node.op->result == 'v';
  std::vector<uint> references;
  for (std::size_t k = 0; k < node.arguments.size(); ++k) {
    const Value a = node.arguments[k];
    const bool is_vector = node.op->arguments[k] == 'v';
    // Tables of all shaders stand in one array.
    const bool is_table = node.op->table && node.op->number < OP_IMAGE_V && k == 1;
    const float base = is_table ? static_cast<float>(library_.tables.size()) : 0.0f;
    references.push_back(is_table ? constant(graph_[a].constant + base, false) : reference(a, is_vector));
  }
  for (const Value a : node.arguments) release(a);
  const uint place = allocate(vector ? 3 : 1);
  places_[static_cast<std::size_t>(v)] = {place, true};
  code_.push_back(node.op->number | (vector ? PROGRAM_VECTOR : 0u) |
                  static_cast<uint>(references.size()) << PROGRAM_COUNT_SHIFT | place << PROGRAM_RESULT_SHIFT);
  code_.push_back(node.mode);
  code_.insert(code_.end(), references.begin(), references.end());
  out_.ops_used[node.op->number / 64] |= std::uint64_t{1} << (node.op->number % 64);
  needs_.add(needs_of(node));
  sources_.push_back(node.source);
}

uint ProgramWriter::constant(vec3 value, bool vector) {
  const auto place = static_cast<uint>(library_.constants.size()) - out_.program.constants;
  library_.constants.push_back(value.x);
  if (vector) library_.constants.insert(library_.constants.end(), {value.y, value.z});
  return REFERENCE_CONSTANT | (vector ? REFERENCE_VECTOR : 0u) | place;
}

uint ProgramWriter::reference(Value v, bool vector) {
  if (graph_.is_constant(v)) return constant(graph_[v].constant, vector);
  return places_[static_cast<std::size_t>(v)].reference | (vector ? REFERENCE_VECTOR : 0u);
}

uint ProgramWriter::allocate(uint size) {
  for (uint first = 0; first + size <= PROGRAM_REGISTERS; ++first) {
    const auto begin = taken_.begin() + first;
    if (std::any_of(begin, begin + size, [](char t) { return t != 0; })) continue;
    std::fill(begin, begin + size, 1);
    library_.registers = std::max(library_.registers, first + size);
    return first;
  }
  throw std::invalid_argument("shader '" + in_.name + "': it keeps more than " + std::to_string(PROGRAM_REGISTERS) +
                              " numbers at a time");
}

// One use of a value is done; after the last its registers are free.
void ProgramWriter::release(Value v) {
  const auto k = static_cast<std::size_t>(v);
  if (graph_.is_constant(v) || --uses_[k] > 0) return;
  const auto first = taken_.begin() + places_[k].reference;
  std::fill(first, first + (graph_.is_vector(v) ? 3 : 1), 0);
}

ProgramPart ProgramWriter::value(Value v) {
  begin({v});
  return finish({reference(v, true)}, {});
}

ProgramPart ProgramWriter::closures(const std::vector<Row> &rows) {
  std::vector<Value> roots;
  for (const Row &row : rows) {
    roots.push_back(row.weight);
    roots.insert(roots.end(), row.arguments.begin(), row.arguments.end());
    if (row.own_normal) roots.push_back(*row.own_normal);
  }
  begin(roots);
  return finish({}, rows);
}

// Stores what was written, or finds the like of it.
ProgramPart ProgramWriter::finish(std::vector<uint> results, const std::vector<Row> &rows) {
  std::vector<uint> words = code_;
  const auto end = static_cast<uint>(words.size());
  std::vector<ClosureRow> records;
  for (const Row &row : rows) {
    const ClosureInfo &info = program_closures()[row.kind];
    if (row.own_normal) words.push_back(reference(*row.own_normal, true));
    records.push_back({row.kind, row.mode, reference(row.weight, true), static_cast<uint>(words.size())});
    for (std::size_t k = 0; info.arguments[k] != 0 && k < row.arguments.size(); ++k) {
      const Value a = row.arguments[k];
      const bool vector = info.arguments[k] == 'v';
      words.push_back(reference(a, vector));
    }
  }
  std::vector<uint> key = words;
  key.insert(key.end(), results.begin(), results.end());
  for (const ClosureRow &r : records) key.insert(key.end(), {r.kind, r.mode, r.weight, r.arguments});
  key.push_back(end);
  const ProgramPart part{static_cast<uint>(library_.code.size()), static_cast<uint>(library_.code.size()) + end,
                         results.empty() ? static_cast<uint>(library_.closures.size()) : results[0],
                         static_cast<uint>(rows.size())};
  const auto [found, made] = library_.shapes_.try_emplace(std::move(key), part);
  if (!made) return found->second;
  for (ClosureRow &r : records) r.arguments += part.first;
  library_.code.insert(library_.code.end(), words.begin(), words.end());
  library_.closures.insert(library_.closures.end(), records.begin(), records.end());
  return part;
}

}  // namespace cotorra
