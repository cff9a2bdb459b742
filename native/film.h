// SPDX-License-Identifier: GPL-3.0-or-later
// The picture while it is rendered: sums by pixel and pass, kept by tiles that one thread at a time works on.
// It knows no scene and no ray.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../kernels/language.h"
#include "../kernels/reweighting.h"
#include "../kernels/sharing.h"

namespace cotorra {

// What a session was asked to keep beside Combined.
struct PassSelection {
  bool nearest = false;  // Depth, Position, Object Index, Material Index: of the sample nearest the pixel's centre
  bool surface = false;  // Normal, UV, Diffuse Color
  bool emission = false;
  bool environment = false;
  bool shadow = false;
  bool occlusion = false;
  bool terms = false;    // D, G, F
  bool error = false;    // adaptive sampling
  bool bright = false;    // Combined with fireflies held back
  bool shared = false;    // Combined of samples that count for several pixels
  bool mixed = false;     // or for their own alone, whatever leaves less noise (sharing_mix.h)
  bool features = false;  // Denoising Albedo, Denoising Normal
  bool health = false;    // bad samples
  std::uint32_t light_groups = 0;
  std::uint32_t lamps = 0;  // passes of single lamps
  bool any_data() const { return features || nearest || surface || emission || environment || shadow || occlusion; }
};

constexpr int kMixSide = 8;  // pixels a side of a block of FilmTile::mix

// Of the camera sample nearest the pixel's centre.
struct NearestRecord {
  float distance2 = 1e30f;  // to the pixel's centre, pixels squared
  float depth = 1e10f;      // Blender's value for "nothing there"
  vec3 position{0.0f, 0.0f, 0.0f};
  float object_index = 0.0f;
  float material_index = 0.0f;
};

// Sums over samples.
struct SurfaceRecord {
  vec3 normal{0.0f, 0.0f, 0.0f};
  vec2 uv{0.0f, 0.0f};
  float uv_coverage = 0.0f;
  vec3 diffuse_color{0.0f, 0.0f, 0.0f};
};

// Sums over samples, of the first rough surface.
struct FeatureRecord {
  vec3 albedo{0.0f, 0.0f, 0.0f};
  vec3 normal{0.0f, 0.0f, 0.0f};
};

// Sums of radiance at the last two powers of two below a pixel's number of samples (noise_estimate.h), by pixel.
struct Marks {
  std::vector<vec3> last;
  std::vector<vec3> before;  // for adaptive sampling alone
};

struct ShadowRecord {
  float lit = 0.0f;       // what arrived
  float unshadowed = 0.0f;  // what would have arrived
};

// Sums over samples, of the sums over lamps.
struct TermRecord {
  float d = 0.0f;
  float g = 0.0f;
  vec3 f{0.0f, 0.0f, 0.0f};
};

// The pixels of one tile. Vectors of passes that nobody asked for stay empty.
struct FilmTile {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<FilmPixel> pixels;  // row by row
  std::uint32_t sample_count = 0;         // taken by each pixel; with adaptive sampling `samples` tells instead
  std::vector<NearestRecord> nearest;
  std::vector<SurfaceRecord> surface;
  std::vector<FeatureRecord> features;
  std::vector<vec3> emission;
  std::vector<vec3> environment;
  std::vector<ShadowRecord> shadow;
  std::vector<float> occlusion;           // sky that is free
  std::vector<TermRecord> terms;
  std::vector<vec3> health;               // samples: not finite or mended, negative, fireflies
  std::vector<BrightSum> bright;          // [pixel * BRIGHT_CASCADES + cascade]
  std::vector<vec3> groups;               // [pixel * light_groups + group]
  std::vector<vec3> lamps;                // [pixel * lamps + lamp]
  std::vector<SharedSum> shared;          // where pixels share samples: what they get (kernels/sharing.h)
  std::vector<float> mix;                 // by block: the part of `shared` in Combined, the rest is each pixel's own
  // Adaptive sampling, and where `mix` is found; of `shared`: means times samples.
  Marks marks, shared_marks;
  std::uint32_t marked = 0;               // the number of samples that the last marks have
  float error_scale = 1.0f;               // adaptive sampling: of film_error, by how fast the error falls here
  float error_fall = 1.41421356f;         // how much film_error fell where samples doubled last
  std::vector<std::uint32_t> samples;     // adaptive sampling: taken by each pixel
  std::vector<std::uint16_t> pending;     // adaptive sampling: pixels still to be sampled, along the Morton curve
  const std::vector<std::uint16_t> *order = nullptr;  // all pixels along the Morton curve, shared by tiles of a size
  std::mutex mutex;                       // held while a batch is added, or a pass is read

  // Takes the passes and the size of `tile`, with all sums zero.
  void clear_as(const FilmTile &tile);
  // Adds the sums of `count` samples of each pixel in to_sample().
  void add(const FilmTile &staged, std::uint32_t count);

  // The mean of what samples count for a pixel, where pixels share them.
  FilmPixel shared_mean(std::size_t pixel) const;
  // Combined.
  FilmPixel mean(std::size_t pixel) const;
  // The part of shared_mean in it.
  float part_shared(std::size_t pixel) const { return mix.empty() ? 1.0f : mix[mix_block(pixel)]; }
  std::size_t mix_block(std::size_t pixel) const;
  std::uint32_t samples_of(std::size_t pixel) const { return samples.empty() ? sample_count : samples[pixel]; }
  const std::vector<std::uint16_t> &to_sample() const { return samples.empty() ? *order : pending; }
};

// How sums become the pictures that a session shows.
struct FilmReading {
  bool transparent = false;
  float reweighting = 0.0f;  // strength, see reweighting.h; 0: Combined is the plain mean
};

// N of a pass that is called "kindN"; ~0 where it is another.
std::uint32_t numbered_pass(const std::string &pass, const std::string &kind);

class Film {
 public:
  // `tile_size` pixels a side, at most 64.
  Film(int width, int height, int tile_size, const PassSelection &passes);

  int width() const { return width_; }
  int height() const { return height_; }
  const PassSelection &passes() const { return passes_; }
  std::size_t tile_count() const { return tiles_.size(); }
  FilmTile &tile(std::size_t index) { return tiles_[index]; }
  std::span<FilmTile> tiles(std::size_t first, std::size_t count) { return std::span(tiles_).subspan(first, count); }
  std::uint64_t bytes() const { return bytes_; }

  // Writes the normalised state of a pass into out[height][width][channels]; row 0 is the bottom. Throws
  // std::invalid_argument for a name that is unknown or was not asked for.
  void read(const std::string &pass, const FilmReading &how, std::span<float> out);
  static int channels(const std::string &pass);

 private:
  int width_, height_;
  PassSelection passes_;
  std::vector<FilmTile> tiles_;
  void make_tiles(int tile_size);

  std::map<std::pair<int, int>, std::vector<std::uint16_t>> orders_;  // by tile width and height
  std::uint64_t bytes_ = 0;
};

}  // namespace cotorra
