// SPDX-License-Identifier: GPL-3.0-or-later
// The records that a kernel reads of a scene: laid out alike in C++ and in GLSL's scalar layout.
// Who fills them (native/scene.cpp) and who owns the memory is not told here.
#ifndef COTORRA_SCENE_TYPES_H
#define COTORRA_SCENE_TYPES_H

#include "language.h"
#include "closure/principled_inputs.h"
#include "program/types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// ---- Features: what a scene uses. One bit is one part of the kernels that can be left out (see FEATURE in
// language.h).
const uint FEATURE_BOUNCES = 1u;           // indirect light: the path goes on after the first hit
const uint FEATURE_SOFT_LIGHTS = 2u;       // a light has a size: its directions are sampled
const uint FEATURE_VISIBLE_LIGHTS = 4u;    // a light with a size can be met by a ray (camera or bounce)
const uint FEATURE_EMISSIVE_MESHES = 8u;   // a material emits: hits emit, and triangles are sampled as lights
const uint FEATURE_WORLD = 16u;            // the world has a colour other than black
const uint FEATURE_SPECULAR = 32u;         // a material has a specular or metallic lobe
const uint FEATURE_BSDF_RAYS =
    64u;        // light is also found by sampling the BSDF (needed by world, emitters, sharp gloss)
const uint FEATURE_DATA_PASSES = 128u;     // passes beyond Combined are written
const uint FEATURE_LIGHT_GROUPS = 256u;    // contributions of lights are kept apart
const uint FEATURE_TRANSPARENCY = 512u;    // a material lets rays through (alpha below 1)
const uint FEATURE_PROGRAMS = 1024u;       // a material varies: its shader is a program
const uint FEATURE_MODELS = 2048u;         // a material has a model other than Principled; implies FEATURE_SPECULAR
const uint FEATURE_LIGHT_SHAPES = 4096u;   // a lamp has a falloff or a spot edge other than Blender's
const uint FEATURE_TERMS = 8192u;          // passes show D, G, F or lamps one by one
const uint FEATURE_OCCLUSION = 16384u;     // ambient occlusion, as a picture, a pass or an ambient term
const uint FEATURE_WHITTED = 32768u;       // the integrator is Whitted
const uint FEATURE_TOON = 65536u;          // the integrator is Toon
const uint FEATURE_LOBES = 131072u;        // a material has lobes that bsdf.h lacks; implies FEATURE_SPECULAR
const uint FEATURE_WORLD_LIGHT = 262144u;  // the world varies, and is sampled as a light; implies FEATURE_PROGRAMS
const uint FEATURE_AREA_LIGHTS = 524288u;  // a lamp is a rectangle or an ellipse; implies FEATURE_SOFT_LIGHTS
const uint FEATURE_HEALTH = 1048576u;      // bad samples are counted, with where they came to be (CPU)
const uint FEATURE_LIGHT_TREE = 2097152u;  // lights are picked by a tree: meshes that emit, or many lamps
const uint FEATURE_LIGHT_LINKING = 4194304u;  // some lights light, or are shadowed by, some objects alone
const uint FEATURE_REWEIGHTING =
    8388608u;  // bright samples are kept apart (reweighting.h); the CPU asks batch by batch
const uint FEATURE_SHARING =
    16777216u;  // samples count for all pixels whose filter reaches them (sharing.h); the CPU asks batch by batch

// ---- Ray visibility, as Blender's visible_* flags; also Embree's ray masks.
const uint VISIBLE_CAMERA = 1u;
const uint VISIBLE_DIFFUSE = 2u;
const uint VISIBLE_GLOSSY = 4u;
const uint VISIBLE_TRANSMISSION = 8u;
const uint VISIBLE_VOLUME = 16u;
const uint VISIBLE_SHADOW = 32u;
const uint VISIBLE_ALL = 63u;      // to some ray of a path
const uint VISIBLE_RAYCAST = 64u;  // to the rays of Raycast nodes
const uint VISIBLE_ANYHOW = 127u;
// Beside the kind of a ray:
const uint RAY_SINGULAR = 128u;     // it left a mirror or clear glass
const uint RAY_REFLECTED = 256u;    // it left a surface on the side that it came from
const uint RAY_MEETS_LAMPS = 512u;  // it left a MATERIAL_SHARP
const uint RAY_BLURRED = 1024u;     // on its way, the path was scattered widely
const uint RAY_SHOWN = 2048u;  // mirrors and clear glass lie behind it, and no surface that a denoiser was shown
const uint RAY_BOTH_SIDES = 4096u;  // it left a surface that light from behind reaches
const uint RAY_HIDDEN = 8192u;  // it left a surface whose smooth normal hides what lies there from light sampling
const uint RAY_DIFFUSE_THROUGH = 16384u;  // VISIBLE_TRANSMISSION, of a diffuse lobe
const uint RAY_SET_SHIFT = 16u;  // above, six bits: the set of objects that it left one of (LightLink.set)

// The sets of objects that shadow are bits of visibility, of instances and of shadow rays to lights that are linked.
const uint SHADOW_SET_SHIFT = 8u;

// What a ray that left a diffuse surface does not meet (SceneData.no_caustics).
const uint CAUSTICS_REFLECTIVE = 1u;
const uint CAUSTICS_REFRACTIVE = 2u;

const uint INVALID_ID = 0xffffffffu;

const uint LIGHT_POINT = 0u;
const uint LIGHT_SUN = 1u;
const uint LIGHT_SPOT = 2u;
const uint LIGHT_AREA = 3u;

const uint LIGHT_SOFT_FALLOFF = 1u;  // a disk that faces the shading point; else a sphere
const uint LIGHT_CAST_SHADOW = 2u;
const uint LIGHT_VISIBLE = 4u;  // bounces can meet it; light sampling then shares the work with them
const uint LIGHT_SEEN = 8u;  // the camera's rays can meet it
// Where passes show lamps one by one, `group` of a lamp holds its pass, counted from 1, above this bit. A light group
// fills the bits below, all of them set for none.
const uint LAMP_PASS_SHIFT = 16u;
const uint LIGHT_SHAPED = 16u;  // its LightShape says how it falls off and ends
const uint LIGHT_ELLIPSE = 32u;  // an area light that is round
const uint LIGHT_PROGRAM = 64u;  // its shader varies: a LightProgram says how

// One lamp. World space; radiometric quantities in the scene's linear colour space.
struct Light {
  vec3 position;  // point, spot, area: metres
  float radius;  // point, spot: metres, 0 = delta; area: of the circle about it
  vec3 axis;  // unit, from the light into the scene (local -Z); sun: the direction of travel
  float spot_versine;  // 1 - cos(spot_size / 2)
  vec3 radiance;  // size above 0: emitted radiance; delta: intensity (W/sr) or, sun, irradiance (W/m2)
  float spot_scale;  // 1 / (spot_versine * blend); large for a hard edge
  vec3 local_x;  // rows of the world-to-local rotation, for spots that are sheared or scaled; area: unit
  float cos_sun;  // sun: cos(angle / 2)
  vec3 local_y;
  uint type;  // LIGHT_*
  vec3 local_z;
  uint flags;  // LIGHT_SOFT_FALLOFF ...
  uint visibility;  // VISIBLE_*: which rays meet the light
  int group;  // light group, -1 = none; see LAMP_PASS_SHIFT
  uint max_bounces;  // last bounce that this light lights
  uint name_index;  // position in the exporter's list, for messages
  float half_u;  // area: half the width along local_x, metres
  float half_v;  // along local_y
  float tan_spread;  // area: tangent of half the angle within which it shines, 0: a beam
  float spread_scale;  // 1 / (tan(h) - h) of that half angle h: the power stays the same
};

const uint FALLOFF_PHYSICAL = 0u;
const uint FALLOFF_RANGED = 1u;
const uint FALLOFF_POLYNOMIAL = 2u;
const uint SPOT_EDGE_BLENDER = 0u;
const uint SPOT_EDGE_LINEAR = 1u;  // in the angle
const uint SPOT_EDGE_SQUARED = 2u;  // the square of a ramp in the cosine

// How a lamp with LIGHT_SHAPED falls off with distance and at the edge of its cone.
struct LightShape {
  uint falloff;  // FALLOFF_*
  uint edge;  // SPOT_EDGE_*
  float inverse_range;  // 1/m
  float c0;  // of 1 / (c0 + c1 d + c2 d^2)
  float c1;
  float c2;
  float edge_end;  // outer angle; SPOT_EDGE_SQUARED: 1 - cos of it
  float edge_scale;  // 1 / (outer - inner) of the same quantity; large for a hard edge
};

const uint MATERIAL_EMISSIVE = 1u;  // emission is not black
const uint MATERIAL_SPECULAR = 2u;  // has a dielectric or metallic lobe
const uint MATERIAL_DIFFUSE = 4u;  // has a diffuse lobe
const uint MATERIAL_TRANSPARENT = 8u;  // alpha below 1
const uint MATERIAL_SAMPLED = 32u;  // its triangles are sampled as lights
const uint MATERIAL_FRONT_DARK = 64u;  // emits nothing to the front
const uint MATERIAL_BACK_DARK = 128u;  // emits nothing to the back
const uint MATERIAL_SHARP = 256u;  // highlights narrower than a lamp may look: bounces meet lamps, too
const uint MATERIAL_MULTI_GGX = 16u;  // microfacet energy is preserved (Blender's "Multiscatter GGX")
const uint MATERIAL_PROGRAM = 512u;  // a part of it varies (MaterialProgram)
const uint MATERIAL_TINTED = 2048u;  // what it lets through has a colour: a program says what
const uint MATERIAL_MODEL = 1024u;  // its reflection model is not Principled
const uint MATERIAL_INDEX_SHIFT = 14u;  // above: of a MATERIAL_MODEL, its place in SceneData.models

// One material: Principled BSDF, as far as it is a constant.
struct Material {
  vec3 base_color;
  float metallic;
  vec3 specular_tint;
  float roughness;  // as the user sets it; alpha = roughness squared
  vec3 emission;  // colour times strength, W/(sr m2)
  float ior;
  float specular_level;  // "Specular IOR Level", 0.5 = as the IOR says
  float alpha;
  uint flags;  // MATERIAL_*
  int pass_index;
};

// ---- Reflection models other than Principled, as the user picks them; see kernels/model.h for what each does.
const uint MODEL_PRINCIPLED = 0u;
const uint MODEL_LAMBERT = 1u;
const uint MODEL_OREN_NAYAR = 2u;
const uint MODEL_PHONG = 3u;
const uint MODEL_BLINN_PHONG = 4u;
const uint MODEL_COOK_TORRANCE = 5u;
const uint MODEL_TOON = 6u;

const uint DISTRIBUTION_GGX = 0u;
const uint DISTRIBUTION_BECKMANN = 1u;
const uint DISTRIBUTION_BLINN_PHONG = 2u;

const uint MASKING_SMITH_CORRELATED = 0u;
const uint MASKING_SMITH = 1u;
const uint MASKING_COOK_TORRANCE = 2u;
const uint MASKING_SCHLICK_GGX = 3u;

const uint FRESNEL_SCHLICK = 0u;
const uint FRESNEL_DIELECTRIC = 1u;
const uint FRESNEL_CONDUCTOR = 2u;
const uint FRESNEL_F82 = 3u;

const uint F0_COLOR = 0u;  // MaterialModel.f0
const uint F0_METALLIC = 1u;  // mix(0.04, base colour, metallic)
const uint F0_IOR = 2u;  // ((ior - 1) / (ior + 1))^2

const uint SPLIT_ENERGY = 0u;  // (1 - F) (1 - metallic) diffuse + specular
const uint SPLIT_MIX = 1u;  // mix(diffuse, specular, metallic)

const uint OREN_NAYAR_QUALITATIVE = 0u;
const uint OREN_NAYAR_ENERGY_PRESERVING = 1u;

// What a material's model has beyond Material. Base colour, roughness, metallic and IOR are there.
struct MaterialModel {
  vec3 specular_color;  // Phong, Blinn-Phong
  float kd;  // factor of the base colour in f, 1/sr: 1 / pi is Lambert's
  vec3 f0;  // with F0_COLOR
  float ks;
  vec3 conductor_n;  // index of refraction, real and imaginary part
  float shininess;
  vec3 conductor_k;
  float oren_nayar_sigma;  // standard deviation of the slopes' angles, radians
  vec3 f82_tint;  // F at 82 degrees over Schlick's
  float ka;  // Whitted: ambient
  vec3 toon_lit;
  float kr;  // Whitted: mirror reflection
  vec3 toon_shade;
  float kt;  // Whitted: refraction
  vec3 absorption;  // Whitted: inside, 1/m
  uint toon_steps;
  uint model;  // MODEL_*
  uint distribution;  // DISTRIBUTION_*
  uint masking;  // MASKING_*
  uint fresnel;  // FRESNEL_*
  uint f0_mode;  // F0_*
  uint split;  // SPLIT_*
  uint normalized;  // 1: the energy-normalised form of Phong or Blinn-Phong
  uint oren_nayar_form;  // OREN_NAYAR_*
};

BUFFER_REF(uint, UintBuffer)
BUFFER_REF(float, FloatBuffer)
BUFFER_REF(vec2, Vec2Buffer)
BUFFER_REF(vec3, Vec3Buffer)
BUFFER_REF(uvec3, Uvec3Buffer)

// One triangle mesh. Buffers that a mesh does not have are null, and its flags say so.
const uint MESH_SMOOTH_VERTEX = 1u;  // normals has one entry a vertex
const uint MESH_SMOOTH_CORNER = 2u;  // normals has one entry a corner
const uint MESH_HAS_UV = 4u;  // uv has one entry a corner
const uint MESH_HAS_SLOTS = 8u;  // material slot per triangle
const uint MESH_HAS_GENERATED = 16u;  // MeshTextures.generated has one entry a vertex

struct Mesh {
  Vec3Buffer positions;  // [vertices], object space, or world space where the mesh is not instanced
  Uvec3Buffer triangles;  // [triangles] vertex indices
  Uvec3Buffer corners;  // [triangles] corner indices
  Vec3Buffer normals;
  Vec2Buffer uv;
  UintBuffer slots;  // [triangles] material slot
  uint flags;  // MESH_*
  uint triangle_count;
};

// One object in the scene.
struct Instance {
  vec3 x_axis;  // object-to-world, by columns; identity where the mesh is in world space already
  uint mesh;
  vec3 y_axis;
  uint material_base;  // its first material in `material_slots`
  vec3 z_axis;
  uint material_count;
  vec3 origin;
  int pass_index;
  vec3 normal_x;  // columns of the inverse transpose, for normals
  uint visibility;
  vec3 normal_y;
  uint flags;  // INSTANCE_*
  vec3 normal_z;
  int light_group;
};
const uint INSTANCE_MIRRORED = 2u;  // the transform turns triangles over, or did when the mesh was moved to world space
const uint INSTANCE_IDENTITY = 1u;  // the transform is the identity
const uint INSTANCE_COPLANAR = 4u;  // some of its triangles may lie in one plane with others
const uint INSTANCE_TERMINATOR_SHIFT = 16u;  // above: Cycles' shadow terminator geometry offset, 0 to 65535

// What a lamp, or an instance that may emit, lights, and what shadows it; see native/scene_lights.cpp.
struct LightLink {
  uvec2 sets;  // of objects that it lights, one a bit
  uint shadows;  // visibility of shadow rays to it
  uint set;  // of an instance: the set that it is lit with
};

const uint EMITTER_DARK_ALONG = 0x80000000u;  // nothing leaves along cross(edge1, edge2)
const uint EMITTER_DARK_AGAINST = 0x40000000u;  // nor against it
const uint EMITTER_MATERIAL = 0x3fffffffu;

// One emitting triangle, in world space. It shines to both sides where none is dark.
struct Emitter {
  vec3 v0;
  uint instance;
  vec3 edge1;
  uint triangle;
  vec3 edge2;
  uint material;  // in EMITTER_MATERIAL, and EMITTER_DARK_*
};

// What Whitted, Toon and the ambient term read of a material beside its BSDF.
const uint CLASSIC_TOON = 1u;  // toon_lit and toon_shade hold; else they come from the base colour

struct ClassicMaterial {
  vec3 absorption;  // inside, 1/m
  float transmission;  // Principled: share of what is no metal that is clear glass
  vec3 toon_lit;
  uint toon_steps;
  vec3 toon_shade;
  float ka;  // Whitted's constants: ambient, reflected and transmitted light (the last two not for Principled)
  float kr;
  float kt;
  uint flags;  // CLASSIC_*
  uint unused;
};

BUFFER_REF(Light, LightBuffer)
BUFFER_REF(LightShape, LightShapeBuffer)
BUFFER_REF(ClassicMaterial, ClassicBuffer)
BUFFER_REF(Material, MaterialBuffer)
BUFFER_REF(Mesh, MeshBuffer)
BUFFER_REF(Instance, InstanceBuffer)
BUFFER_REF(Emitter, EmitterBuffer)
BUFFER_REF(MaterialModel, MaterialModelBuffer)
BUFFER_REF(LightLink, LightLinkBuffer)
BUFFER_REF(uvec2, Uvec2Buffer)

// ---- What programs read. All of the buffers are null where no material is a program (without FEATURE_PROGRAMS).
const uint TEXELS_UINT8 = 0u;  // the largest number of both integer kinds is 1
const uint TEXELS_UINT16 = 1u;
const uint TEXELS_HALF = 2u;
const uint TEXELS_FLOAT = 3u;
const uint INTERPOLATION_CLOSEST = 0u;
const uint INTERPOLATION_LINEAR = 1u;
const uint INTERPOLATION_CUBIC = 2u;
const uint EXTENSION_REPEAT = 0u;
const uint EXTENSION_EXTEND = 1u;
const uint EXTENSION_CLIP = 2u;
const uint EXTENSION_MIRROR = 3u;
const uint NORMAL_TANGENT = 0u;  // what the directions of a normal map are relative to
const uint NORMAL_OBJECT = 1u;
const uint NORMAL_WORLD = 2u;
const uint NORMAL_BLENDER_OBJECT = 3u;  // as Blender once baked them: two axes point the other way
const uint NORMAL_BLENDER_WORLD = 4u;
const uint ATTRIBUTE_NONE = 0u;  // what an attribute has one entry for
const uint ATTRIBUTE_POINT = 1u;
const uint ATTRIBUTE_CORNER = 2u;
const uint ATTRIBUTE_FACE = 3u;  // one a triangle
const uint ATTRIBUTE_INSTANCE = 4u;
const uint ATTRIBUTE_KIND_MASK = 255u;
const uint ATTRIBUTE_COMPONENTS_SHIFT = 8u;  // above: how many numbers of four are its own

// An image as its file has it: rows from below, channels side by side.
struct Texture {
  UintBuffer texels;  // [width * height * channels] numbers of `format`, packed, with the padding of the last word
  uint width;
  uint height;
  uint channels;  // 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  uint format;  // TEXELS_*
  uint srgb;  // 1: colours are decoded after filtering
  uint unused;
};

BUFFER_REF(vec4, Vec4Buffer)

// What programs need of a mesh beside Mesh.
struct MeshTextures {
  Vec4Buffer tangents;  // [layers * corners] object space, and the sign of the bitangent
  Vec3Buffer generated;  // [vertices]
  Vec4Buffer attributes;  // all layers one after the other
  UintBuffer attribute_table;  // for each layer behind those of UV maps ATTRIBUTE_*, and its first entry
  uint corner_count;  // entries of a layer of Mesh.uv and of tangents
  uint uv_layers;
  uint tangent_layers;
  uint moved;  // 1: positions and normals were moved to world space, and the frame below tells from where
  vec3 x_axis;  // object-to-world, by columns
  vec3 y_axis;
  vec3 z_axis;
  vec3 normal_x;  // columns of its inverse transpose
  vec3 normal_y;
  vec3 normal_z;
  uint attribute_words;  // of attribute_table
  uint unused;
};

// From world space to that of an object or camera, by rows; and where its origin lies in the world.
struct ObjectSpace {
  vec4 x;
  vec4 y;
  vec4 z;
  vec3 origin;
  uint unused;
};

// The shader of a lamp that varies: a factor of its radiance.
struct LightProgram {
  ProgramPart emission;
  uint constants;
  float mean;  // luminance of the factor on average, to choose lamps by
  float uv_scale;  // spot: half the cotangent of half its angle; sun: 1 / (2 sin(angle / 4)), 0 without an angle
  uint unused;
  ObjectSpace space;
  vec3 x_axis;  // object-to-world, by columns
  vec3 y_axis;
  vec3 z_axis;
  uint unused2;
};

// What the Object Info node tells of an instance.
struct InstanceInfo {
  vec3 location;
  float alpha;
  vec3 color;
  float random;
};

BUFFER_REF(Texture, TextureBuffer)
BUFFER_REF(MeshTextures, MeshTexturesBuffer)
BUFFER_REF(ObjectSpace, ObjectSpaceBuffer)
BUFFER_REF(InstanceInfo, InstanceInfoBuffer)
BUFFER_REF(LightProgram, LightProgramBuffer)

// What traces the rays of programs on a CPU (program/rays.h); elsewhere a stage has its own way (trace.glsl).
#ifdef __cplusplus
struct RayTracer;
BUFFER_REF(RayTracer, RayTracerBuffer)
#else
BUFFER_REF(uint, RayTracerBuffer)
#endif

// The whole scene, as a kernel sees it.
RECORD(SceneData) {
  LightBuffer lights;
  MaterialBuffer materials;
  UintBuffer material_slots;
  MeshBuffer meshes;
  InstanceBuffer instances;
  EmitterBuffer emitters;
  FloatBuffer albedo;  // tables of bsdf_tables.h
  FloatBuffer filter_table;  // inverse CDF of the pixel filter, then its density from the middle
  MaterialModelBuffer models;  // [materials]; null where all are Principled and the integrator asks for nothing
  ClassicBuffer classic;  // by material
  uint light_count;
  uint emitter_count;
  uint instance_count;
  uint material_count;
  vec3 world;  // radiance of the background
  uint world_visibility;
  uint tree_picks;  // lights that are picked by the tree at a path's first vertex; at others one is
  int world_group;
  LightShapeBuffer light_shapes;  // one for each lamp; null where no lamp is LIGHT_SHAPED
  LightProgramBuffer light_programs;  // one for each lamp; null where no lamp is a LIGHT_PROGRAM
  TextureBuffer textures;
  MaterialProgramBuffer programs;  // [materials]
  UintBuffer program_code;
  ClosureRowBuffer program_closures;
  FloatBuffer program_constants;
  FloatBuffer tables;  // ramps and curves of all programs
  MeshTexturesBuffer mesh_textures;  // [meshes]
  ObjectSpaceBuffer object_spaces;  // [instances], null where no program asks
  InstanceInfoBuffer instance_infos;  // [instances], null where no program asks
  Vec4Buffer instance_attributes;  // [layers * instances]
  FloatBuffer world_table;  // cumulated brightness: [world_height][world_width], then of the rows [world_height]
  FloatBuffer light_nodes;  // [nodes * LIGHT_NODE_FLOATS] of the light tree; null where no light is picked by it
  UintBuffer light_parents;  // [nodes] place of each node: node x LIGHT_FANOUT + child; INVALID_ID for the first
  UintBuffer light_places;  // [lamps] in the tree; where meshes emit, [instances] where their triangles begin in here
  LightLinkBuffer light_links;  // [lamps + instances]; null where nothing is linked
  Uvec2Buffer light_node_sets;  // [nodes * LIGHT_FANOUT] LightLink.sets of all lights of a child together
  RayTracerBuffer tracer;  // null where no program traces rays
  ObjectSpace camera_space;  // x to the right, y up, z forward
  vec4 camera_window;  // left, bottom, 1 / width, 1 / height of the picture at distance 1, or in metres
  uint camera_orthographic;
  uint uv_layer_count;  // layers of UV maps, which come before those of attributes
  uint light_kinds;  // 1: diffuse or glossy rays alone see some light (PathState.kind_weight)
  uint
      lobes;  // 1: closures are lobes; 0: the constants of the nearest Principled, as the classic integrators know them
  float camera_spread;  // metres that a ray of a pixel is wide, a metre on; orthographic: anywhere
  uint starts_at_point;  // 1: rays may start at the very point that they leave, and then do not meet its triangle
  uint texture_count;
  ProgramPart world_program;  // of a world that varies; end 0: `world` is all of it
  uint world_constants;
  uint no_caustics;  // CAUSTICS_*
  uint world_width;  // of world_table; 0: bounces alone find the world
  uint world_height;
  vec3 world_sun;  // unit, to the middle of the sun's disc in a sky
  float world_sun_cap;  // 1 - cos of its half angle
  float world_sun_share;  // of the samples, that go to it and not by the table
  uint world_sampled;  // VISIBLE_*: what lobes' light is drawn by the table; others see another world, or none
  uint world_max_bounces;  // last bounce that it lights
  float sharp_roughness;  // Principled: from here on bounces leave lamps to light sampling
  uint seed;  // of the random numbers of programs
  uint light_linking;  // 1: there are light_links
  float camera_near;  // metres along the viewing axis behind which the camera's rays begin
};

#ifdef __cplusplus
static_assert(sizeof(Light) == 128 && sizeof(Material) == 64 && sizeof(Mesh) == 56 && sizeof(Instance) == 112 &&
              sizeof(Emitter) == 48 && sizeof(LightLink) == 16 && sizeof(LightShape) == 32 &&
              sizeof(MaterialModel) == 160 && sizeof(ClassicMaterial) == 64 && sizeof(SceneData) == 456);
static_assert(sizeof(Texture) == 32 && sizeof(MeshTextures) == 128 && sizeof(ObjectSpace) == 64 &&
              sizeof(InstanceInfo) == 32 && sizeof(LightProgram) == 136);
}  // namespace cotorra
#endif

#endif
