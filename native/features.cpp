// SPDX-License-Identifier: GPL-3.0-or-later
// The table of features: bit, name, and why a scene may do without.
#include "features.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "../kernels/scene_types.h"

namespace cotorra {
namespace {

struct Feature {
  std::uint32_t bit;
  const char *name;
  const char *absent;
};

constexpr Feature kFeatures[] = {
    {FEATURE_BOUNCES, "bounces", "the integrator is Direct, or allows no bounces"},
    {FEATURE_SOFT_LIGHTS, "soft lights", "no lamp has a size"},
    {FEATURE_VISIBLE_LIGHTS, "visible lights", "no lamp with a size can be met by a ray"},
    {FEATURE_EMISSIVE_MESHES, "emissive meshes", "no material in use emits"},
    {FEATURE_WORLD, "world", "the background is black"},
    {FEATURE_SPECULAR, "specular lobe", "all materials in use are Lambertian"},
    {FEATURE_BSDF_RAYS, "light found by bounces",
     "lamps are sampled directly, and no gloss is sharp enough to need more"},
    {FEATURE_DATA_PASSES, "data passes", "only Combined is asked for"},
    {FEATURE_LIGHT_GROUPS, "light groups", "no light group is asked for"},
    {FEATURE_TRANSPARENCY, "transparency", "all materials in use are opaque"},
    {FEATURE_PROGRAMS, "programs", "all materials in use are constant"},
    {FEATURE_MODELS, "reflection models", "all materials in use are Principled"},
    {FEATURE_LIGHT_SHAPES, "light shapes", "all lamps fall off as Blender's do"},
    {FEATURE_TERMS, "terms", "no pass shows D, G, F or single lamps"},
    {FEATURE_OCCLUSION, "ambient occlusion", "neither the integrator nor a pass asks for it"},
    {FEATURE_WHITTED, "Whitted", "another integrator is chosen"},
    {FEATURE_TOON, "toon", "another integrator is chosen"},
    {FEATURE_LOBES, "lobes", "no material in use has coat, sheen, glass or the like"},
    {FEATURE_WORLD_LIGHT, "world as a light",
     "the world is nearly the same in all directions, or bounces alone find it"},
    {FEATURE_AREA_LIGHTS, "area lights", "no lamp is a rectangle or an ellipse"},
    {FEATURE_HEALTH, "numerical health", "nobody counts bad samples"},
    {FEATURE_LIGHT_LINKING, "light linking", "no light is linked to objects"},
    {FEATURE_REWEIGHTING, "reweighting", "fireflies are not held back by their weight"},
    {FEATURE_SHARING, "sharing", "each sample counts for its own pixel alone"},
    {FEATURE_LIGHT_TREE, "light tree", "no mesh emits, and there are few lamps: each is sampled"},
};

}  // namespace

std::vector<std::string> feature_names(std::uint32_t features) {
  std::vector<std::string> names;
  for (const Feature &f : kFeatures) {
    if ((features & f.bit) != 0) names.emplace_back(f.name);
  }
  return names;
}

std::uint32_t features_of(const std::vector<std::string> &names) {
  std::uint32_t features = 0;
  for (const std::string &name : names) {
    const auto *found =
        std::find_if(std::begin(kFeatures), std::end(kFeatures), [&](const Feature &f) { return name == f.name; });
    if (found == std::end(kFeatures)) throw std::invalid_argument("no feature is called '" + name + "'");
    features |= found->bit;
  }
  return features;
}

std::vector<std::string> left_out(std::uint32_t features) {
  std::vector<std::string> reasons;
  for (const Feature &f : kFeatures) {
    if ((features & f.bit) == 0) reasons.push_back(std::string(f.name) + ": " + f.absent);
  }
  return reasons;
}

}  // namespace cotorra
