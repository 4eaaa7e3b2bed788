// Reads values from the bytes of a fuzz input, and reports violated conditions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace sweepstake::fuzz {

// Takes small numbers and pieces from the front. At the end all numbers are 0 and all pieces empty.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : rest_(reinterpret_cast<const char*>(data), size) {}

  bool empty() const { return rest_.empty(); }
  uint8_t Byte() {
    const std::string_view byte = Take(1);
    return byte.empty() ? 0 : static_cast<uint8_t>(byte.front());
  }
  uint32_t TwoBytes() {
    const uint32_t low = Byte();
    return low | uint32_t{Byte()} << 8;
  }
  // Takes a piece that is preceded by its length in two bytes, little-endian.
  std::string_view Piece() { return Take(TwoBytes()); }
  std::string_view Rest() { return Take(rest_.size()); }

 private:
  std::string_view Take(size_t size) {
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view rest_;
};

// Aborts the program unless `holds`; the fuzzer then reports the input.
inline void Require(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "not so: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

}  // namespace sweepstake::fuzz
