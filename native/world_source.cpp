// SPDX-License-Identifier: GPL-3.0-or-later
// What tells that a world is the same as before, so that its table need not be made anew: its shader as it was read,
// and which memory its images are. What the table is made of is world_table.cpp's.
#include <algorithm>
#include <bit>

#include "../kernels/program/ops.h"
#include "world_table.h"

namespace cotorra {
namespace {

// Beside directions, these ask for what the scene holds.
constexpr uint kScene[] = {OP_ATTRIBUTE, OP_ATTRIBUTE_ALPHA, OP_ATTRIBUTE_FAC, OP_AO,
                           OP_BEVEL,     OP_RAYCAST,         OP_RAYCAST_NORMAL};

constexpr bool reads_image(uint op) { return op == OP_IMAGE_V || op == OP_IMAGE_F || op == OP_ENVIRONMENT_V; }

class Words {
 public:
  explicit Words(std::vector<std::uint32_t> &out) : out_(out) {}
  void add(float number) { out_.push_back(std::bit_cast<std::uint32_t>(number)); }
  void add(std::uint32_t number) { out_.push_back(number); }
  void add(int number) { out_.push_back(static_cast<std::uint32_t>(number)); }
  void add(vec3 v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  void add(const ShaderInput::Closure &c) {
    add(c.kind);
    add(c.mode);
    add(c.weight);
    add(c.first_argument);
  }
  template <class Item>
  void add(std::span<const Item> items) {
    add(static_cast<std::uint32_t>(items.size()));
    for (const Item &item : items) add(item);
  }

 private:
  std::vector<std::uint32_t> &out_;
};

}  // namespace

std::optional<WorldSource> world_source(const ShaderInput &shader, std::span<const ImageInput> images, uint kinds,
                                        int resolution, const WorldSun &sun) {
  WorldSource source;
  // 1. The images, of which the shader has the numbers.
  std::size_t first = 0;  // argument of the op
  for (const uint number : shader.ops) {
    const OpInfo *op = find_op(number);
    if (op == nullptr || std::find(std::begin(kScene), std::end(kScene), number) != std::end(kScene)) {
      return std::nullopt;
    }
    if (reads_image(number)) {
      const int reference = shader.args[first + 1];
      if (reference >= 0) return std::nullopt;  // any image
      const float index = shader.constants[static_cast<std::size_t>(~reference)].x;
      if (!(index >= 0.0f) || !(index < static_cast<float>(images.size()))) return std::nullopt;  // image_index
      const ImageInput &image = images[static_cast<std::size_t>(index)];
      source.images.push_back({reinterpret_cast<std::uintptr_t>(image.pixels), image.width, image.height,
                               image.channels, image.format, image.srgb ? std::uintptr_t{1} : 0});
    }
    first += op->arguments.size();
  }
  // 2. All else.
  Words words(source.words);
  words.add(shader.ops);
  words.add(shader.modes);
  words.add(shader.args);
  words.add(shader.constants);
  words.add(shader.closures);
  words.add(shader.closure_args);
  words.add(shader.tables);
  words.add(kinds);
  words.add(resolution);
  words.add(sun.direction);
  words.add(sun.cap);
  return source;
}

}  // namespace cotorra
