// SPDX-License-Identifier: GPL-3.0-or-later
// The one header that knows whether a kernel is compiled as C++20 or as GLSL 4.60.
// It maps a common vocabulary onto both languages; it holds no physics.
#ifndef COTORRA_LANGUAGE_H
#define COTORRA_LANGUAGE_H

// FEATURE(BIT): is this part of the kernel compiled in? In C++ each translation unit defines KERNEL_FEATURES as a
// constant before it includes a kernel; in GLSL it is a specialization constant. What is off leaves no code behind.
#ifdef __cplusplus

#include "language_cpp.h"  // vec2, vec3, uvec3, dot, normalize, mix ... as GLSL defines them

#define IN(T) const T &
#define OUT(T) T &
#define INOUT(T) T &
#define BUFFER_REF(T, NAME) \
  struct NAME {             \
    const T *v;             \
  };
#define BUFFER_RW(T, NAME) \
  struct NAME {            \
    T *v;                  \
  };
#define RECORD(T) struct T
#define RECORD_REF(T) const T *
#define FEATURE(BIT) ((KERNEL_FEATURES & (BIT)) != 0u)

#else

#define FN
#define IN(T) T
#define OUT(T) out T
#define INOUT(T) inout T
#define BUFFER_REF(T, NAME) \
  layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer NAME { T v[]; };
#define BUFFER_RW(T, NAME) \
  layout(buffer_reference, scalar, buffer_reference_align = 8) buffer NAME { T v[]; };
// A record that is handed on by its address. A struct would be copied at each call, which costs drivers much to undo.
#define RECORD(T) layout(buffer_reference, scalar, buffer_reference_align = 8) buffer T
#define RECORD_REF(T) T
#define FEATURE(BIT) ((KERNEL_FEATURES & (BIT)) != 0u)
#define select(CONDITION, IF_TRUE, IF_FALSE) ((CONDITION) ? (IF_TRUE) : (IF_FALSE))

#endif

// Both languages read element I of the device array R, whose type was declared by BUFFER_REF(T, NAME), or write one
// that was declared by BUFFER_RW(T, NAME).
#define LOAD(R, I) ((R).v[I])
#define STORE(R, I, VALUE) ((R).v[I] = (VALUE))

#endif
