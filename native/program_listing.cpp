// SPDX-License-Identifier: GPL-3.0-or-later
// Reads programs back from their code, and takes the time of the instructions. Words for people are not made here.
#include "program_listing.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "cpu_kernel.h"
#include "scene.h"

#include "every_feature.h"

#include "../kernels/integrator.h"
#include "cpu_program.h"

namespace cotorra {
namespace {

// Finds what references mean, from the instruction that wrote each register last.
struct References {
  const ProgramLibrary &library;
  uint constants;
  std::array<int, PROGRAM_REGISTERS> writer{};

  ListedValue value(uint reference) const {
    ListedValue v;
    v.vector = (reference & REFERENCE_VECTOR) != 0;
    const std::size_t place = reference & REFERENCE_MASK;
    if ((reference & REFERENCE_CONSTANT) == 0) {
      v.instruction = writer[place];
      return v;
    }
    const float *numbers = library.constants.data() + constants + place;
    v.constant = v.vector ? vec3(numbers[0], numbers[1], numbers[2]) : vec3(numbers[0]);
    return v;
  }
};

// Points spread over the triangles of the first instance, each seen from its front; or directions all around.
std::vector<ShaderPoint> points_of(const SceneData &scene, std::span<const Instance> instances,
                                   std::span<const Mesh> meshes) {
  std::vector<ShaderPoint> points;
  for (uint i = 0; i < static_cast<uint>(kProgramLanes); ++i) {
    const vec2 u = sampler_pair(i, 0x51a7u);
    if (instances.empty() || meshes[instances[0].mesh].triangle_count == 0) {
      const float z = 1.0f - 2.0f * u.x;
      const float r = std::sqrt(std::max(1.0f - z * z, 0.0f));
      const float angle = 6.2831853f * u.y;
      points.push_back(background_point(vec3(r * std::cos(angle), r * std::sin(angle), z)));
      continue;
    }
    const vec2 b = triangle_from_square(u);
    const Hit hit{1.0f, b.x, b.y, i % meshes[instances[0].mesh].triangle_count, 0, 0};
    Surface s;
    surface_from_hit(scene, hit, vec3(0.0f, 0.0f, -1.0f), s);
    points.push_back(shader_point(s, s.ng, 1.0f));
    points.back().footprint = 1e-3f;
  }
  return points;
}

}  // namespace

ProgramListing list_program(const ProgramLibrary &library, const MaterialProgram &program, const ProgramPart &part,
                            const std::vector<int> &sources) {
  ProgramListing listing;
  References references{library, program.constants};
  const std::vector<uint> &code = library.code;
  for (uint word = part.first; word < part.end;) {
    const uint head = code[word];
    const uint count = (head >> PROGRAM_COUNT_SHIFT) & PROGRAM_COUNT_MASK;
    const std::size_t index = listing.instructions.size();
    ListedInstruction line{
        find_op(head & PROGRAM_OP_MASK), code[word + 1], {}, index < sources.size() ? sources[index] : -1};
    for (uint k = 0; k < count; ++k) line.arguments.push_back(references.value(code[word + 2 + k]));
    word += 2 + count;
    const uint place = head >> PROGRAM_RESULT_SHIFT;
    const uint end = place + ((head & PROGRAM_VECTOR) != 0 ? 3u : 1u);
    std::fill(references.writer.begin() + place, references.writer.begin() + end, static_cast<int>(index));
    listing.registers = std::max(listing.registers, end);
    listing.instructions.push_back(std::move(line));
  }
  if (part.closures == 0) {
    listing.result = references.value(part.result);
    return listing;
  }
  for (uint k = 0; k < part.closures; ++k) {
    const ClosureRow &row = library.closures[part.result + k];
    const ClosureInfo &kind = program_closures()[row.kind];
    ListedClosure closure{&kind, row.mode, references.value(row.weight), {}};
    for (uint a = 0; kind.arguments[a] != 0; ++a) {
      closure.arguments.push_back(references.value(code[row.arguments + a]));
    }
    listing.closures.push_back(std::move(closure));
  }
  return listing;
}

double program_cost(const Scene &scene, const MaterialProgram &program, const ProgramPart &part) {
  constexpr double kSeconds = 2e-3;  // at most, save for the first runs
  constexpr int kRuns = 5;           // at least
  const std::vector<ShaderPoint> points = points_of(scene.data(), scene.instances(), scene.meshes());
  const std::vector<uint> constants(points.size(), program.constants);
  std::vector<float> registers(std::max<std::size_t>(scene.programs().registers, 1) * kProgramStride);
  const ProgramBatch batch{&scene.data(), points.data(), constants.data(), static_cast<int>(points.size()),
                           registers.data()};
  const RunProgram run = choose_cpu_program();
  // The fastest run: whatever else the machine does only makes others slower.
  double best = 1e30, total = 0.0;
  for (int i = 0; i < kRuns || total < kSeconds; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    run(batch, part.first, part.end);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    best = std::min(best, took.count());
    total += took.count();
  }
  return best * 1e9 / static_cast<double>(points.size());
}

}  // namespace cotorra
