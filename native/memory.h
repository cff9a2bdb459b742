// SPDX-License-Identifier: GPL-3.0-or-later
// What is said where the machine's memory runs out: how much was needed, and what for.
// Memory of graphics cards is vulkan_api.h's.
#pragma once

#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>

namespace cotorra {

// Python sees a MemoryError with this text.
class OutOfMemory : public std::bad_alloc {
 public:
  OutOfMemory(std::uint64_t bytes, const std::string &purpose)
      : text_("out of memory: " + std::to_string((bytes >> 20) + 1) + " MiB for " + purpose) {}
  const char *what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

// Does `work`, which needs about so many bytes for the purpose; where it fails for want of memory, that is said.
template <class Work>
auto with_memory(std::uint64_t bytes, const std::string &purpose, Work work) {
  try {
    return work();
  } catch (const OutOfMemory &) {
    throw;
  } catch (const std::bad_alloc &) {
    throw OutOfMemory(bytes, purpose);
  } catch (const std::length_error &) {  // more than a vector can count
    throw OutOfMemory(bytes, purpose);
  }
}

}  // namespace cotorra
