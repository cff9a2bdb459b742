// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a SceneBuffers' shaders, images and attributes by the names of their arrays. Nothing is checked but types and
// shapes.
#include "python_programs.h"

#include "python_arrays.h"

namespace cotorra {
namespace {

ImageInput read_image(nb::handle image, MakeOwner make_owner) {
  ImageInput in;
  in.name = nb::cast<std::string>(nb::getattr(image, "name"));
  const std::string what = "image '" + in.name + "': pixels ";
  nb::object pixels = nb::getattr(image, "pixels");
  nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu> array;
  if (!nb::try_cast(pixels, array, false)) throw std::invalid_argument(what + "are no C-contiguous array");
  if (array.ndim() != 3) {
    throw std::invalid_argument(what + "have " + std::to_string(array.ndim()) +
                                " dimensions, expected rows, columns and channels");
  }
  const nb::dlpack::dtype type = array.dtype();
  const auto is = [&](nb::dlpack::dtype_code code, unsigned bits) {
    return type.code == static_cast<std::uint8_t>(code) && type.bits == bits && type.lanes == 1;
  };
  if (is(nb::dlpack::dtype_code::UInt, 8)) {
    in.format = TEXELS_UINT8;
  } else if (is(nb::dlpack::dtype_code::UInt, 16)) {
    in.format = TEXELS_UINT16;
  } else if (is(nb::dlpack::dtype_code::Float, 16)) {
    in.format = TEXELS_HALF;
  } else if (is(nb::dlpack::dtype_code::Float, 32)) {
    in.format = TEXELS_FLOAT;
  } else {
    throw std::invalid_argument(what + "are " + nb::cast<std::string>(nb::repr(nb::getattr(pixels, "dtype"))) +
                                ", expected uint8, uint16, float16 or float32");
  }
  in.height = array.shape(0);
  in.width = array.shape(1);
  in.channels = array.shape(2);
  in.pixels = array.data();
  in.srgb = nb::cast<bool>(nb::getattr(image, "srgb"));
  in.owner = make_owner({std::move(pixels)});
  return in;
}

// Structured arrays do not pass borders: as their words.
std::span<const ShaderInput::Closure> read_closures(nb::handle closures, std::vector<nb::object> &keep) {
  nb::object words = nb::getattr(closures, "view")("uint32");
  Array<std::uint32_t> array;
  if (!nb::try_cast(words, array, false)) throw std::invalid_argument("closures is no C-contiguous array");
  constexpr std::size_t size = sizeof(ShaderInput::Closure) / sizeof(std::uint32_t);
  if (array.size() % size != 0) throw std::invalid_argument("closures must have records of four words");
  keep.push_back(std::move(words));
  return {reinterpret_cast<const ShaderInput::Closure *>(array.data()), array.size() / size};
}

// A shader's arrays; its closures are records of four words.
ShaderInput read_shader(nb::handle shader, std::vector<nb::object> &keep) {
  ShaderInput in;
  in.name = nb::cast<std::string>(nb::getattr(shader, "name"));
  try {
    in.ops = view<uint, std::uint32_t>(shader, "ops", keep);
    in.modes = view<uint, std::uint32_t>(shader, "modes", keep);
    in.args = view<int, std::int32_t>(shader, "args", keep);
    in.constants = view<vec3, float>(shader, "constants", keep);
    in.closures = read_closures(nb::getattr(shader, "closures"), keep);
    in.closure_args = view<int, std::int32_t>(shader, "closure_args", keep);
    in.tables = view<float, float>(shader, "tables", keep);
  } catch (const std::invalid_argument &error) {
    throw std::invalid_argument("shader '" + in.name + "': " + error.what());
  }
  return in;
}

uint domain_of(const std::string &name) {
  if (name == "POINT") return ATTRIBUTE_POINT;
  if (name == "CORNER") return ATTRIBUTE_CORNER;
  if (name == "FACE") return ATTRIBUTE_FACE;
  throw std::invalid_argument("an attribute's domain is '" + name + "', must be POINT, CORNER or FACE");
}

}  // namespace

std::vector<AttributeInput> read_attributes(nb::handle mesh, std::vector<nb::object> &keep) {
  std::vector<AttributeInput> found;
  const nb::object attributes = nb::getattr(mesh, "attributes", nb::none());
  if (attributes.is_none()) return found;
  for (nb::handle attribute : attributes) {
    found.push_back({nb::cast<uint>(nb::getattr(attribute, "layer")),
                     domain_of(nb::cast<std::string>(nb::getattr(attribute, "domain"))),
                     nb::cast<uint>(nb::getattr(attribute, "components")),
                     view<vec4, float>(attribute, "values", keep)});
  }
  return found;
}

ProgramsInput read_programs(nb::handle buffers, MakeOwner make_owner, std::vector<nb::object> &keep) {
  ProgramsInput in;
  for (nb::handle shader : nb::getattr(buffers, "shaders")) in.shaders.push_back(read_shader(shader, keep));
  for (nb::handle image : nb::getattr(buffers, "images")) in.images.push_back(read_image(image, make_owner));
  in.uv_layers = static_cast<uint>(nb::len(nb::getattr(buffers, "uv_layers")));
  in.attribute_layers = static_cast<uint>(nb::len(nb::getattr(buffers, "attribute_layers")));
  for (nb::handle layer : nb::getattr(buffers, "instance_layers")) in.instance_layers.push_back(nb::cast<uint>(layer));
  const nb::object instances = nb::getattr(buffers, "instances");
  in.instance_attributes = view<vec4, float>(instances, "attributes", keep);
  const nb::object info = nb::getattr(instances, "info", nb::none());
  if (info.is_none()) return in;
  in.info_color = view<vec4, float>(info, "color", keep);
  in.info_random = view<float, float>(info, "random", keep);
  return in;
}

}  // namespace cotorra
