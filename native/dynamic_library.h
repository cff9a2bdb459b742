// SPDX-License-Identifier: GPL-3.0-or-later
// Opening a shared library at run time, on each system. Which libraries, and what is looked up in them, is told where
// they are used.
#pragma once

#include <string>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace cotorra {

#ifdef _WIN32
inline void *open_library(const std::string &path) { return reinterpret_cast<void *>(LoadLibraryA(path.c_str())); }
inline void close_library(void *handle) { FreeLibrary(reinterpret_cast<HMODULE>(handle)); }
inline void *find_symbol(void *handle, const char *name) {
  return reinterpret_cast<void *>(GetProcAddress(reinterpret_cast<HMODULE>(handle), name));
}
inline std::string open_error() { return "error " + std::to_string(GetLastError()); }
#else
inline void *open_library(const std::string &path) { return dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL); }
inline void close_library(void *handle) { dlclose(handle); }
inline void *find_symbol(void *handle, const char *name) { return dlsym(handle, name); }
inline std::string open_error() {
  const char *text = dlerror();
  return text != nullptr ? text : "unknown error";
}
#endif

}  // namespace cotorra
