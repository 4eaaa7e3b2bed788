// A .aabbs file as a scene. Frames are read from the file one at a time. Memory: one frame, plus 4
// bytes per frame if the object count changes.
//
// Not thread-safe. Opening reads the whole file once, to find broken boxes before they are used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/scene/aabbs_format.h"
#include "sweepstake/scene.h"

namespace sweepstake {

class RecordedScene final : public Scene {
 public:
  // Opens a file. Errors: kNotFound if it does not exist; kDataLoss if it is broken, with a line
  // that names the file and the fault (for a box also frame and object); kResourceExhausted if it
  // has more than kMaxSceneObjectCount objects.
  static Result<std::unique_ptr<Scene>> Open(const std::filesystem::path& path);

  // Returns the file's notes, empty if it has none. Errors: as for Open.
  static Result<std::string> NotesOf(const std::filesystem::path& path);

  // Returns the name in the header, or "recorded" if the header has no name.
  std::string_view name() const override { return header_.scene_name; }
  Aabb world() const override { return header_.world; }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override { return {boxes_.data(), shown_count_}; }
  size_t max_object_count() const override { return boxes_.size(); }
  // Reads the next frame. If the file has become unreadable, the boxes of the last readable frame
  // stay.
  void DoStep() override;

 private:
  RecordedScene() = default;

  static Result<std::unique_ptr<RecordedScene>> OpenFile(const std::filesystem::path& path);
  Status ReadHeader(const std::filesystem::path& path);
  Status CheckNotes(uint64_t file_bytes) const;
  // `file_bytes` is the size without the notes.
  Status CheckSize(uint64_t file_bytes);
  Status ReadCountTable(uint64_t file_bytes);
  Status CheckBoxes();
  Status CheckFrame(uint64_t file_frame) const;
  // Shows the next frame of the file. On failure the boxes stay unchanged.
  bool ReadNextFrame();
  bool ReadBoxes(size_t count);
  void Rewind();
  size_t CountOf(uint64_t file_frame) const;

  std::ifstream file_;
  aabbs::Header header_;
  std::vector<uint32_t> counts_;  // count of each frame; empty if all frames have the same
  std::vector<Aabb> boxes_;
  std::vector<std::byte> bytes_;  // one frame in the format of the file
  size_t shown_count_ = 0;
  uint64_t next_file_frame_ = 0;
  uint64_t frame_index_ = 0;
};

}  // namespace sweepstake
