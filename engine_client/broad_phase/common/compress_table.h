// Tables of the lane indices that move the lanes set in a mask to the front of a register
// (compress-inl.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sweepstake {

struct CompressTable {
  // Entry m lists the set bits of m in ascending order, then zeros.
  std::array<std::array<uint8_t, 8>, 256> of8{};
  // Entry m lists the set bits of m as lanes of 32 bits, each by the indices of its four bytes.
  alignas(16) std::array<std::array<uint8_t, 16>, 16> bytes_of4{};
};

constexpr CompressTable MakeCompressTable() {
  CompressTable table;
  for (size_t mask = 0; mask < table.of8.size(); ++mask) {
    size_t count = 0;
    for (uint8_t lane = 0; lane < 8; ++lane) {
      if ((mask >> lane & 1) != 0) table.of8[mask][count++] = lane;
    }
  }
  for (size_t mask = 0; mask < table.bytes_of4.size(); ++mask) {
    for (size_t byte = 0; byte < 16; ++byte) {
      table.bytes_of4[mask][byte] = static_cast<uint8_t>(4 * table.of8[mask][byte / 4] + byte % 4);
    }
  }
  return table;
}

inline constexpr CompressTable kCompressTable = MakeCompressTable();

}  // namespace sweepstake
