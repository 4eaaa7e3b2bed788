#include "engine_client/c_api/sized_struct.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace sweepstake::c_api {
namespace {

// Upper bound, in bytes, of the size of every struct. A struct_size that was never set is usually
// above it and is rejected before memory beyond the struct is read.
constexpr uint32_t kMaxBytes = 4096;

// Reads only struct_size, because a struct with an invalid size may end right after it.
swp_result ReadSize(const SizedStruct& type, const void* given, uint32_t& size) noexcept {
  std::memcpy(&size, given, sizeof size);
  const auto earlier = type.earlier_sizes;
  const bool known = size == type.size || (size > type.size && size <= kMaxBytes) ||
                     std::find(earlier.begin(), earlier.end(), size) != earlier.end();
  if (known) return SWP_OK;
  std::array<char, 192> message;
  const int length = static_cast<int>(type.name.size());
  std::snprintf(message.data(), message.size(),
                "struct_size of %.*s is %u, an unknown size (%u in this library): set it to "
                "sizeof(%.*s) before the call",
                length, type.name.data(), size, type.size, length, type.name.data());
  return Fail(SWP_INVALID_ARGUMENT, message.data());
}

swp_result UnknownField(const SizedStruct& type) noexcept {
  std::array<char, 192> message;
  std::snprintf(message.data(), message.size(),
                "%.*s has a field set that this library (ABI %u, revision %u) does not know: leave "
                "it 0, or load a newer library",
                static_cast<int>(type.name.size()), type.name.data(), SWP_ABI_VERSION,
                SWP_ABI_REVISION);
  return Fail(SWP_INVALID_ARGUMENT, message.data());
}

}  // namespace

swp_result TakeSized(const SizedStruct& type, const void* given, void* known) noexcept {
  uint32_t size = 0;
  if (const swp_result wrong = ReadSize(type, given, size); wrong != SWP_OK) return wrong;
  if (size > type.size) {
    const std::span tail(static_cast<const std::byte*>(given) + type.size, size - type.size);
    const auto is_set = [](std::byte byte) { return byte != std::byte{0}; };
    if (std::any_of(tail.begin(), tail.end(), is_set)) return UnknownField(type);
  }
  std::memcpy(known, given, std::min(size, type.size));
  std::memcpy(known, &type.size, sizeof type.size);
  return SWP_OK;
}

swp_result GiveSized(const SizedStruct& type, const void* known, void* out) noexcept {
  uint32_t size = 0;
  if (const swp_result wrong = ReadSize(type, out, size); wrong != SWP_OK) return wrong;
  auto* const bytes = static_cast<std::byte*>(out);
  const uint32_t common = std::min(size, type.size);
  std::memcpy(bytes + sizeof size, static_cast<const std::byte*>(known) + sizeof size,
              common - sizeof size);
  std::memset(bytes + common, 0, size - common);
  return SWP_OK;
}

}  // namespace sweepstake::c_api
