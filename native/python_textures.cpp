// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a SceneBuffers' images and textures by the names of their arrays. Nothing is checked but types and shapes.
#include "python_textures.h"

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

// The structured array of slots, as its bytes: NumPy's records do not pass borders.
std::span<const TextureSlot> read_slots(nb::handle textures, std::vector<nb::object> &keep) {
  nb::object slots = nb::getattr(textures, "slots");
  const auto size = nb::cast<std::size_t>(nb::getattr(nb::getattr(slots, "dtype"), "itemsize"));
  if (size != sizeof(TextureSlot)) {
    throw std::invalid_argument("textures.slots has records of " + std::to_string(size) + " bytes, expected " +
                                std::to_string(sizeof(TextureSlot)));
  }
  nb::object bytes = nb::getattr(slots, "view")("uint8");
  Array<std::uint8_t> array;
  if (!nb::try_cast(bytes, array, false)) throw std::invalid_argument("textures.slots is no C-contiguous array");
  keep.push_back(std::move(bytes));
  return {reinterpret_cast<const TextureSlot *>(array.data()), array.size() / sizeof(TextureSlot)};
}

}  // namespace

TexturesInput read_textures(nb::handle buffers, MakeOwner make_owner, std::vector<nb::object> &keep) {
  TexturesInput in;
  const nb::object textures = nb::getattr(nb::getattr(buffers, "materials"), "textures", nb::none());
  if (textures.is_none()) return in;
  in.slots = read_slots(textures, keep);
  in.inputs = view<int, std::int32_t>(textures, "inputs", keep);
  in.normal_strength = view<float, float>(textures, "normal_strength", keep);
  in.normal_tangent = view<uint, std::uint32_t>(textures, "normal_tangent", keep);
  in.normal_space = view<uint, std::uint32_t>(textures, "normal_space", keep);
  for (nb::handle image : nb::getattr(buffers, "images")) in.images.push_back(read_image(image, make_owner));
  const nb::object spaces = nb::getattr(nb::getattr(buffers, "instances"), "spaces", nb::none());
  if (!spaces.is_none()) in.world_to_object = view<float, float>(spaces, "world_to_object", keep);
  return in;
}

}  // namespace cotorra
