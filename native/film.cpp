// SPDX-License-Identifier: GPL-3.0-or-later
// Lays out a film's tiles and turns their sums into passes.
#include "film.h"

#include <algorithm>
#include <functional>
#include <stdexcept>

#include "../kernels/sampling.h"
#include "memory.h"
#include "noise_estimate.h"
#include "reweighting.h"

namespace cotorra {
namespace {

std::vector<std::uint16_t> morton_order(int width, int height) {
  std::vector<std::uint16_t> order;
  for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(height); ++y) {
    for (std::uint32_t x = 0; x < static_cast<std::uint32_t>(width); ++x) {
      order.push_back(static_cast<std::uint16_t>(y * static_cast<std::uint32_t>(width) + x));
    }
  }
  std::sort(order.begin(), order.end(), [width](std::uint32_t a, std::uint32_t b) {
    const auto w = static_cast<std::uint32_t>(width);
    return morton_encode(a % w, a / w) < morton_encode(b % w, b / w);
  });
  return order;
}

// Of a pixel with its passes.
std::uint64_t pixel_bytes(const PassSelection &passes) {
  const auto if_kept = [](bool kept, std::size_t bytes) { return kept ? bytes : 0; };
  const std::size_t mark = (passes.shared ? 2 : 1) * sizeof(vec3);
  return sizeof(FilmPixel) + if_kept(passes.shared, sizeof(SharedSum)) + if_kept(passes.error || passes.mixed, mark) +
         if_kept(passes.error, mark) + if_kept(passes.bright, BRIGHT_CASCADES * sizeof(BrightSum)) +
         if_kept(passes.error, sizeof(std::uint32_t) + sizeof(std::uint16_t)) +
         if_kept(passes.nearest, sizeof(NearestRecord)) + if_kept(passes.surface, sizeof(SurfaceRecord)) +
         if_kept(passes.features, sizeof(FeatureRecord)) + if_kept(passes.emission, sizeof(vec3)) +
         if_kept(passes.environment, sizeof(vec3)) + if_kept(passes.shadow, sizeof(ShadowRecord)) +
         if_kept(passes.health, sizeof(vec3)) + if_kept(passes.occlusion, sizeof(float)) +
         if_kept(passes.terms, sizeof(TermRecord)) + (std::uint64_t{passes.light_groups} + passes.lamps) * sizeof(vec3);
}

// One pixel of a pass: reads tile and pixel index, writes channels.
using Reader = std::function<void(const FilmTile &, std::size_t, float *)>;

void write(vec3 v, float *out) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

float per_sample(const FilmTile &t, std::size_t i) {
  const std::uint32_t n = t.samples_of(i);
  return n > 0 ? 1.0f / static_cast<float>(n) : 0.0f;
}

Reader reader_of(const std::string &pass, const PassSelection &has, bool transparent) {
  if (pass == "combined" || pass == "unweighted") {
    return [transparent](const FilmTile &t, std::size_t i, float *out) {
      const FilmPixel mean = t.mean(i);
      write(mean.radiance, out);
      out[3] = transparent || t.samples_of(i) > 0 ? mean.alpha : 1.0f;  // holdouts leave nothing of an opaque film
    };
  }
  if (pass == "sample_count") {
    return [](const FilmTile &t, std::size_t i, float *out) { out[0] = static_cast<float>(t.samples_of(i)); };
  }
  if (has.error && pass == "noise") {
    return [](const FilmTile &t, std::size_t i, float *out) { out[0] = noise_left(t, i); };
  }
  if (has.nearest) {
    if (pass == "depth") return [](const FilmTile &t, std::size_t i, float *out) { out[0] = t.nearest[i].depth; };
    if (pass == "position") {
      return [](const FilmTile &t, std::size_t i, float *out) { write(t.nearest[i].position, out); };
    }
    if (pass == "object_index") {
      return [](const FilmTile &t, std::size_t i, float *out) { out[0] = t.nearest[i].object_index; };
    }
    if (pass == "material_index") {
      return [](const FilmTile &t, std::size_t i, float *out) { out[0] = t.nearest[i].material_index; };
    }
  }
  if (has.surface) {
    if (pass == "normal") {
      return [](const FilmTile &t, std::size_t i, float *out) { write(t.surface[i].normal * per_sample(t, i), out); };
    }
    if (pass == "uv") {
      return [](const FilmTile &t, std::size_t i, float *out) {
        const SurfaceRecord &r = t.surface[i];
        write(vec3(r.uv.x, r.uv.y, r.uv_coverage) * per_sample(t, i), out);
      };
    }
    if (pass == "diffuse_color") {
      return [](const FilmTile &t, std::size_t i, float *out) {
        write(t.surface[i].diffuse_color * per_sample(t, i), out);
      };
    }
  }
  if (has.features) {
    if (pass == "denoising_albedo") {
      return [](const FilmTile &t, std::size_t i, float *out) { write(t.features[i].albedo * per_sample(t, i), out); };
    }
    if (pass == "denoising_normal") {
      return [](const FilmTile &t, std::size_t i, float *out) { write(t.features[i].normal * per_sample(t, i), out); };
    }
  }
  if (has.emission && pass == "emission") {
    return [](const FilmTile &t, std::size_t i, float *out) { write(t.emission[i] * per_sample(t, i), out); };
  }
  if (has.environment && pass == "environment") {
    return [](const FilmTile &t, std::size_t i, float *out) { write(t.environment[i] * per_sample(t, i), out); };
  }
  if (has.shadow && pass == "shadow") {
    return [](const FilmTile &t, std::size_t i, float *out) {
      const ShadowRecord &r = t.shadow[i];
      write(vec3(r.unshadowed > 0.0f ? r.lit / r.unshadowed : 1.0f), out);
    };
  }
  if (has.occlusion && pass == "ao") {
    return [](const FilmTile &t, std::size_t i, float *out) { write(vec3(t.occlusion[i] * per_sample(t, i)), out); };
  }
  if (has.health && pass == "health") {
    return [](const FilmTile &t, std::size_t i, float *out) { write(t.health[i], out); };
  }
  if (has.terms) {
    if (pass == "term_d") {
      return [](const FilmTile &t, std::size_t i, float *out) { out[0] = t.terms[i].d * per_sample(t, i); };
    }
    if (pass == "term_g") {
      return [](const FilmTile &t, std::size_t i, float *out) { out[0] = t.terms[i].g * per_sample(t, i); };
    }
    if (pass == "term_f") {
      return [](const FilmTile &t, std::size_t i, float *out) { write(t.terms[i].f * per_sample(t, i), out); };
    }
  }
  if (const std::uint32_t group = numbered_pass(pass, "lightgroup:"); group < has.light_groups) {
    const std::size_t stride = has.light_groups;
    return [group, stride](const FilmTile &t, std::size_t i, float *out) {
      write(t.groups[i * stride + group] * per_sample(t, i), out);
    };
  }
  if (const std::uint32_t lamp = numbered_pass(pass, "light:"); lamp < has.lamps) {
    const std::size_t stride = has.lamps;
    return [lamp, stride](const FilmTile &t, std::size_t i, float *out) {
      write(t.lamps[i * stride + lamp] * per_sample(t, i), out);
    };
  }
  throw std::invalid_argument("pass '" + pass + "' is unknown, or the session was not asked to keep it");
}

}  // namespace

std::uint32_t numbered_pass(const std::string &pass, const std::string &kind) {
  const std::string digits = pass.starts_with(kind) ? pass.substr(kind.size()) : "";
  const bool number = !digits.empty() && digits.size() < 9 &&
                      std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  return number ? static_cast<std::uint32_t>(std::stoul(digits)) : ~0u;
}

void FilmTile::clear_as(const FilmTile &tile) {
  pixels.assign(tile.pixels.size(), FilmPixel{vec3(0.0f), 0.0f});
  shared.assign(tile.shared.size(), SharedSum{{vec3(0.0f), 0.0f}, 0.0f});
  nearest.assign(tile.nearest.size(), NearestRecord{});
  surface.assign(tile.surface.size(), SurfaceRecord{});
  features.assign(tile.features.size(), FeatureRecord{});
  emission.assign(tile.emission.size(), vec3(0.0f));
  environment.assign(tile.environment.size(), vec3(0.0f));
  shadow.assign(tile.shadow.size(), ShadowRecord{});
  occlusion.assign(tile.occlusion.size(), 0.0f);
  terms.assign(tile.terms.size(), TermRecord{});
  health.assign(tile.health.size(), vec3(0.0f));
  bright.assign(tile.bright.size(), BrightSum{vec3(0.0f), 0.0f});
  groups.assign(tile.groups.size(), vec3(0.0f));
  lamps.assign(tile.lamps.size(), vec3(0.0f));
}

// Divided, not multiplied: samples of 1 are to have the mean 1.
FilmPixel FilmTile::shared_mean(std::size_t pixel) const {
  const SharedSum &sum = shared[pixel];
  if (!(sum.weight > 0.0f)) return {vec3(0.0f), 0.0f};
  const vec3 r = sum.film.radiance;
  return {vec3(r.x / sum.weight, r.y / sum.weight, r.z / sum.weight), sum.film.alpha / sum.weight};
}

// Alpha is divided by the samples: times their inverse, a film that is whole would not have 1 to the bit.
FilmPixel FilmTile::mean(std::size_t pixel) const {
  const float s = per_sample(*this, pixel);
  const float alpha = s > 0.0f ? pixels[pixel].alpha / static_cast<float>(samples_of(pixel)) : 0.0f;
  const FilmPixel own{pixels[pixel].radiance * s, alpha};
  if (shared.empty()) return own;
  const FilmPixel all = shared_mean(pixel);
  const float part = part_shared(pixel);
  return {own.radiance + (all.radiance - own.radiance) * part, own.alpha + (all.alpha - own.alpha) * part};
}

std::size_t FilmTile::mix_block(std::size_t pixel) const {
  const auto w = static_cast<std::size_t>(width), side = static_cast<std::size_t>(kMixSide);
  return pixel / w / side * ((w + side - 1) / side) + pixel % w / side;
}

void FilmTile::add(const FilmTile &staged, std::uint32_t count) {
  const std::lock_guard lock(mutex);
  for (const std::uint16_t i : to_sample()) {
    pixels[i].radiance += staged.pixels[i].radiance;
    pixels[i].alpha += staged.pixels[i].alpha;
    if (!shared.empty()) {
      shared[i].film.radiance += staged.shared[i].film.radiance;
      shared[i].film.alpha += staged.shared[i].film.alpha;
      shared[i].weight += staged.shared[i].weight;
    }
    if (!samples.empty()) samples[i] += count;
    if (!nearest.empty() && staged.nearest[i].distance2 < nearest[i].distance2) nearest[i] = staged.nearest[i];
    if (!surface.empty()) {
      surface[i].normal += staged.surface[i].normal;
      surface[i].uv = surface[i].uv + staged.surface[i].uv;
      surface[i].uv_coverage += staged.surface[i].uv_coverage;
      surface[i].diffuse_color += staged.surface[i].diffuse_color;
    }
    if (!features.empty()) {
      features[i].albedo += staged.features[i].albedo;
      features[i].normal += staged.features[i].normal;
    }
    if (!emission.empty()) emission[i] += staged.emission[i];
    if (!environment.empty()) environment[i] += staged.environment[i];
    if (!shadow.empty()) {
      shadow[i].lit += staged.shadow[i].lit;
      shadow[i].unshadowed += staged.shadow[i].unshadowed;
    }
    if (!occlusion.empty()) occlusion[i] += staged.occlusion[i];
    if (!health.empty()) health[i] += staged.health[i];
    if (!terms.empty()) {
      terms[i].d += staged.terms[i].d;
      terms[i].g += staged.terms[i].g;
      terms[i].f += staged.terms[i].f;
    }
    const std::size_t b = bright.size() / pixels.size();
    for (std::size_t c = i * b; c < (i + 1) * b; ++c) {
      bright[c].light += staged.bright[c].light;
      bright[c].count += staged.bright[c].count;
    }
    const std::size_t n = groups.size() / pixels.size();
    for (std::size_t g = 0; g < n; ++g) groups[i * n + g] += staged.groups[i * n + g];
    const std::size_t m = lamps.size() / pixels.size();
    for (std::size_t l = 0; l < m; ++l) lamps[i * m + l] += staged.lamps[i * m + l];
  }
  sample_count += count;
}

Film::Film(int width, int height, int tile_size, const PassSelection &passes)
    : width_(width),
      height_(height),
      passes_(passes),
      bytes_(static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) * pixel_bytes(passes)) {
  with_memory(bytes_, "a picture of " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
              [&] { make_tiles(tile_size); });
}

void Film::make_tiles(int tile_size) {
  const PassSelection &passes = passes_;
  const int columns = (width_ + tile_size - 1) / tile_size;
  const int rows = (height_ + tile_size - 1) / tile_size;
  std::vector<FilmTile> tiles(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  tiles_.swap(tiles);
  std::size_t k = 0;
  for (int row = rows - 1; row >= 0; --row) {  // from the top, where people look first
    for (int column = 0; column < columns; ++column) {
      FilmTile &t = tiles_[k++];
      t.x0 = column * tile_size;
      t.y0 = row * tile_size;
      t.width = std::min(tile_size, width_ - t.x0);
      t.height = std::min(tile_size, height_ - t.y0);
      const auto n = static_cast<std::size_t>(t.width) * static_cast<std::size_t>(t.height);
      t.pixels.assign(n, FilmPixel{vec3(0.0f), 0.0f});
      auto &order = orders_[{t.width, t.height}];
      if (order.empty()) order = morton_order(t.width, t.height);
      t.order = &order;
      if (passes.shared) t.shared.assign(n, SharedSum{{vec3(0.0f), 0.0f}, 0.0f});
      if (passes.error || passes.mixed) t.marks.last.assign(n, vec3(0.0f));
      if (passes.error) t.marks.before.assign(n, vec3(0.0f));
      if (passes.shared && (passes.error || passes.mixed)) t.shared_marks.last.assign(n, vec3(0.0f));
      if (passes.shared && passes.error) t.shared_marks.before.assign(n, vec3(0.0f));
      if (passes.error) {
        t.samples.assign(n, 0);
        t.pending = order;
      }
      if (passes.nearest) t.nearest.resize(n);
      if (passes.surface) t.surface.resize(n);
      if (passes.features) t.features.resize(n);
      if (passes.emission) t.emission.assign(n, vec3(0.0f));
      if (passes.environment) t.environment.assign(n, vec3(0.0f));
      if (passes.shadow) t.shadow.resize(n);
      if (passes.occlusion) t.occlusion.assign(n, 0.0f);
      if (passes.terms) t.terms.resize(n);
      if (passes.health) t.health.assign(n, vec3(0.0f));
      if (passes.bright) t.bright.assign(n * BRIGHT_CASCADES, BrightSum{vec3(0.0f), 0.0f});
      if (passes.light_groups > 0) t.groups.assign(n * passes.light_groups, vec3(0.0f));
      if (passes.lamps > 0) t.lamps.assign(n * passes.lamps, vec3(0.0f));
    }
  }
}

int Film::channels(const std::string &pass) {
  if (pass == "combined" || pass == "unweighted") return 4;
  if (pass == "term_d" || pass == "term_g" || pass == "depth" || pass == "object_index" || pass == "material_index" ||
      pass == "sample_count" || pass == "noise")
    return 1;
  return 3;
}

void Film::read(const std::string &pass, const FilmReading &how, std::span<float> out) {
  const auto n = static_cast<std::size_t>(channels(pass));
  if (out.size() != static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * n) {
    throw std::invalid_argument("pass '" + pass + "': the array has " + std::to_string(out.size()) +
                                " entries, expected " + std::to_string(height_) + " x " + std::to_string(width_) +
                                " x " + std::to_string(n));
  }
  const Reader reader = reader_of(pass, passes_, how.transparent);
  for (FilmTile &t : tiles_) {
    const std::lock_guard lock(t.mutex);
    std::size_t i = 0;
    for (int y = 0; y < t.height; ++y) {
      float *row =
          out.data() +
          (static_cast<std::size_t>(t.y0 + y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(t.x0)) * n;
      for (int x = 0; x < t.width; ++x, ++i) reader(t, i, row + static_cast<std::size_t>(x) * n);
    }
  }
  if (pass == "combined" && passes_.bright) reweight(tiles_, width_, height_, how.reweighting, out);
}

}  // namespace cotorra
