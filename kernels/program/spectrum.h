#include "elementary.h"
#ifdef __cplusplus
namespace cotorra {
#endif
FN vec3 op_blackbody(uint, float t) { return vec3(t); }
FN vec3 op_wavelength(uint, float t) { return vec3(t); }
#ifdef __cplusplus
}
#endif
