// Files that hold one JSON document with the name and the version of its format: manifests, records
// of runs, cost traces. They are written atomically. Thread-safe on different files.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

struct DocumentFormat {
  const char* name;         // the document's member `format`
  int version;              // its member `version`
  const char* kind;         // completes the error "FILE is not …", e.g. "a cost trace"
  const char* remedy = "";  // appended to errors: "; make it again with ..."
  bool is_cbor = false;     // else text, indented by two spaces if `is_indented`
  bool is_indented = false;
};

// Writes `content` with the members `format` and `version`. Errors: those of WholeFile.
Status WriteDocument(const std::filesystem::path& path, const DocumentFormat& format,
                     const nlohmann::ordered_json& content);

// Reads the file and passes the document to `take`. `take` returns what is wrong with the document,
// or an empty text; it may also throw the errors of the JSON library. Errors: kNotFound (the file
// does not exist), kDataLoss (the file is not a document of this format and version, or `take`
// found an error). Each message names the file.
Status ReadDocument(const std::filesystem::path& path, const DocumentFormat& format,
                    const std::function<std::string(const nlohmann::json&)>& take);

}  // namespace sweepstake::cli
