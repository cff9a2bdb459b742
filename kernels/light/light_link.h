// SPDX-License-Identifier: GPL-3.0-or-later
// Light linking and shadow linking: which lights light an object, and which objects shadow a light. As in Cycles,
// objects that are linked alike make a set. Who makes the sets is addon/export/linking.py.
#ifndef COTORRA_LIGHT_LINK_H
#define COTORRA_LIGHT_LINK_H

#include "../scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN bool has_links(IN(SceneData) scene) { return FEATURE(FEATURE_LIGHT_LINKING) && scene.light_linking != 0u; }

FN bool sets_hold(uvec2 sets, uint set) { return ((select(set < 32u, sets.x, sets.y) >> (set & 31u)) & 1u) != 0u; }

// The set that an instance is lit with.
FN uint receiver_set(IN(SceneData) scene, uint instance) {
  return has_links(scene) ? LOAD(scene.light_links, scene.light_count + instance).set : 0u;
}

// Does a light light the objects of a set? `link`: the index of a lamp, or behind those of an instance.
FN bool light_lights(IN(SceneData) scene, uint link, uint set) {
  return !has_links(scene) || sets_hold(LOAD(scene.light_links, link).sets, set);
}

// Visibility of shadow rays to a light, where it has shadows at all.
FN uint light_shadows(IN(SceneData) scene, uint link) {
  return has_links(scene) ? LOAD(scene.light_links, link).shadows : VISIBLE_SHADOW;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
