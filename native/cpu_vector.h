// SPDX-License-Identifier: GPL-3.0-or-later
// How loops over lanes are told to compilers, so that they become vector code.
#pragma once

#include <cstddef>

// Everything that such a loop calls must be inlined into it; not with sanitizers, whose checks would take minutes.
#if defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COTORRA_FLATTEN [[gnu::flatten, gnu::noinline]]
#define COTORRA_APART [[gnu::noinline]]
#define COTORRA_LOOP [[gnu::flatten, gnu::noinline]] static
#else
#define COTORRA_FLATTEN
#define COTORRA_APART
#define COTORRA_LOOP [[maybe_unused]] static
#endif

// For loops whose choices hang on one number of several values: g++ would make one jump of them, which is no vector
// code.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COTORRA_UNTHREADED [[gnu::optimize("no-thread-jumps")]]
#else
#define COTORRA_UNTHREADED
#endif

// Over n points. What is written at one of them is read at no other.
#if defined(__GNUC__) && !defined(__clang__)
#define COTORRA_EACH _Pragma("GCC ivdep") for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
#else
#define COTORRA_EACH for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
#endif
