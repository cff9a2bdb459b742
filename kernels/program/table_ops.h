#ifndef COTORRA_PROGRAM_TABLE_OPS_H
#define COTORRA_PROGRAM_TABLE_OPS_H
#include "pure.h"
#include "../scene_types.h"
#ifdef __cplusplus
namespace cotorra {
#endif
FN vec3 program_table(IN(SceneData) scene, uint op, uint mode, IN(ProgramArguments) a) { return vec3(float(op + mode) * a.v[0] * scene.world.x); }
#ifdef __cplusplus
}
#endif
#endif
