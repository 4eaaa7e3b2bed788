// Encodes and decodes the parts of a .aabbs file: header, boxes and count table. The README.md of
// this folder describes the format.
//
// Pure functions on bytes. recorded_scene and record_scene open and read the file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sweepstake/aabb.h"
#include "sweepstake/status.h"

namespace sweepstake::aabbs {

inline constexpr size_t kHeaderBytes = 304;
inline constexpr size_t kBoxBytes = 32;
inline constexpr size_t kCountBytes = 4;
inline constexpr size_t kNameBytes = 128;
inline constexpr int32_t kMaxNotesBytes = 16 << 20;

enum class Layout : int32_t {
  kFixedCount = 0,     // Broadmark's layout: (1 + frames) * N boxes
  kChangingCount = 1,  // our layout: N is the maximum count; a table of counts follows the boxes
};

struct Header {
  std::string scene_name;
  int32_t object_count = 0;  // the count of every frame, or the maximum of all frames
  int32_t frame_count = 0;   // number of frames after the spawn state
  Layout layout = Layout::kFixedCount;
  int32_t notes_bytes = 0;  // size of the notes at the end of the file
  Aabb world{};

  uint64_t frames_with_spawn() const { return uint64_t{1} + static_cast<uint32_t>(frame_count); }
};

using HeaderBytes = std::array<std::byte, kHeaderBytes>;

// Encodes the header. Cuts a name longer than 127 bytes. Replaces bytes of the name that are not
// printable ASCII by '?'.
HeaderBytes EncodeHeader(const Header& header);

// Decodes the header and checks every field. The file's size is not checked here. Error kDataLoss:
// the message names the broken field and what is wrong with it.
Result<Header> DecodeHeader(const HeaderBytes& bytes);

void EncodeBox(const Aabb& box, std::span<std::byte, kBoxBytes> bytes);
Aabb DecodeBox(std::span<const std::byte, kBoxBytes> bytes);

void EncodeInt32(int32_t value, std::span<std::byte, kCountBytes> bytes);
int32_t DecodeInt32(std::span<const std::byte, kCountBytes> bytes);

// Returns whether all six coordinates are finite. Inverted boxes are legal and overlap nothing.
bool IsFinite(const Aabb& box);

}  // namespace sweepstake::aabbs
