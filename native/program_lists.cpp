// SPDX-License-Identifier: GPL-3.0-or-later
// The ops and closures that shaders are made of, as kernels/program/ops.inc and kernels/closure/kinds.h number them.
// What becomes of those of a shader is program_compile.cpp's.
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

#include "health.h"
#include "program_compile.h"

#include "../kernels/program/ops.h"

namespace cotorra {
namespace {

enum class OpKind { CONTEXT, PURE, TABLE };

constexpr ClosureInfo kClosures[] = {
    {"emission", CLOSURE_EMISSION, "v"},
    {"transparent", CLOSURE_TRANSPARENT, "v"},
    {"holdout", CLOSURE_HOLDOUT, ""},
    {"diffuse", CLOSURE_DIFFUSE, "vfv"},
    {"translucent", CLOSURE_TRANSLUCENT, "vv"},
    {"glossy", CLOSURE_GLOSSY, "vfffvv"},
    {"metallic", CLOSURE_METALLIC, "vvvvfffvvff"},
    {"glass", CLOSURE_GLASS, "vffvff"},
    {"refraction", CLOSURE_REFRACTION, "vffv"},
    {"sheen", CLOSURE_SHEEN, "vfv"},
    {"toon", CLOSURE_TOON, "vffv"},
    {"principled", CLOSURE_PRINCIPLED, "vfffvffvffffvffvffffvvffvvffff"},
};

std::vector<OpInfo> make_ops() {
  std::vector<OpInfo> ops;
#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) \
  ops.push_back({#NAME, NUMBER, OpKind::KIND != OpKind::CONTEXT, OpKind::KIND == OpKind::TABLE, *#RESULT, #ARGUMENTS});
#include "../kernels/program/ops.inc"
#undef PROGRAM_OP
  return ops;
}

}  // namespace

ProgramNeeds needs_of_ops(std::span<const std::string> names) {
  ProgramNeeds needs;
  for (const std::string &name : names) {
    const auto ops = program_ops();
    const auto op = std::find_if(ops.begin(), ops.end(), [&](const OpInfo &o) { return o.name == name; });
    if (op == ops.end()) throw std::invalid_argument("no op is called '" + name + "'");
    needs.add({program_group(op->number) | GROUP_PROGRAM, ~0u});
  }
  return needs;
}

std::span<const OpInfo> program_ops() {
  static const std::vector<OpInfo> ops = make_ops();
  return ops;
}

const OpInfo *find_op(uint number) {
  static const auto table = [] {
    std::array<const OpInfo *, OP_NUMBERS> found{};
    for (const OpInfo &op : program_ops()) found[op.number] = &op;
    return found;
  }();
  return number < table.size() ? table[number] : nullptr;
}

std::span<const ClosureInfo> program_closures() { return kClosures; }

std::uint32_t closure_arguments(std::uint32_t kind) {
  return static_cast<std::uint32_t>(std::string_view(program_closures()[kind].arguments).size());
}

}  // namespace cotorra
