#include "elementary.h"
#ifdef __cplusplus
namespace cotorra {
#endif
FN vec3 op_radial_tiling_v(uint, vec3 v, float, float) { return v; }
FN float op_radial_tiling_f(uint, vec3 v, float, float) { return v.x; }
#ifdef __cplusplus
}
#endif
