// Helpers for the .aabbs tests: a directory per test, reading and writing whole files, and scenes
// with scripted boxes.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sweepstake/scene.h"

namespace sweepstake {

// An empty directory for this test, which is removed at its end.
class FileTest : public testing::Test {
 protected:
  FileTest() {
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::path(testing::TempDir()) /
                 (std::string("sweepstake_") + test.test_suite_name() + "_" + test.name());
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
  }

  ~FileTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(directory_, ignored);
  }

  std::filesystem::path PathOf(const std::string& name) const { return directory_ / name; }

  std::filesystem::path Write(const std::string& bytes) const {
    std::filesystem::path path = PathOf("scene.aabbs");
    // Some file systems flush a truncated file to the disk when it is written again, so remove it
    // first.
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  static std::string Read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  size_t FileCount() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(directory_), {}));
  }

 private:
  std::filesystem::path directory_;
};

// A scene that shows the given frames, and then repeats the last one.
class ScriptedScene final : public Scene {
 public:
  explicit ScriptedScene(std::vector<std::vector<Aabb>> frames) : frames_(std::move(frames)) {}

  std::string_view name() const override { return name_; }
  Aabb world() const override { return {{-1, -2, -3}, {1, 2, 3}}; }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override {
    return frames_[std::min<size_t>(frame_index_, frames_.size() - 1)];
  }
  void DoStep() override { ++frame_index_; }
  void set_name(std::string name) { name_ = std::move(name); }

 private:
  std::string name_ = "scripted";
  std::vector<std::vector<Aabb>> frames_;
  uint64_t frame_index_ = 0;
};

inline Aabb BoxAt(float x) { return {{x, x + 1, x + 2}, {x + 10, x + 11, x + 12}}; }

// An independent writer of the format: appends little-endian fields.
class FileBytes {
 public:
  FileBytes& Text(std::string text, size_t size) {
    text.resize(size);
    bytes_ += text;
    return *this;
  }

  FileBytes& Int(int32_t value) {
    for (int shift = 0; shift < 32; shift += 8) {
      bytes_ += static_cast<char>((static_cast<uint32_t>(value) >> shift) & 0xFFU);
    }
    return *this;
  }

  FileBytes& Float(float value) { return Int(std::bit_cast<int32_t>(value)); }

  FileBytes& Box(const Aabb& box) {
    for (const float x : box.min) Float(x);
    Float(0);
    for (const float x : box.max) Float(x);
    return Float(0);
  }

  FileBytes& Header(int32_t object_count, int32_t frame_count, int32_t layout = 0) {
    Text("crates", 128).Text("Box", 128).Int(object_count).Int(frame_count).Int(layout).Int(0);
    return Box({{-1, -1, -1}, {1, 1, 1}});
  }

  FileBytes& Boxes(int count) {
    for (int i = 0; i < count; ++i) Box(BoxAt(static_cast<float>(i)));
    return *this;
  }

  const std::string& str() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace sweepstake
